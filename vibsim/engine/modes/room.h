/* Room for what a scene or a mode counts. */
#ifndef VIBSIM_ROOM_H
#define VIBSIM_ROOM_H

#include <stdlib.h>

enum { MOST = 100000 }; /* of anything in a scene or a mode */

#ifdef __cplusplus
/* Room that goes into a pointer of any type, as in C. */
struct Room {
    void *at;
    template <class T> operator T *() const { return static_cast<T *>(at); }
};
#else
typedef void *Room;
#endif

static inline Room room(size_t count, size_t size)
{
#ifdef __cplusplus
    return Room{calloc(count ? count : 1, size)};
#else
    return calloc(count ? count : 1, size);
#endif
}

/* `old`, grown to so many bytes, or NULL. */
static inline Room regrown(void *old, size_t size)
{
#ifdef __cplusplus
    return Room{realloc(old, size)};
#else
    return realloc(old, size);
#endif
}

#endif
