/* Memory for what a scene or a mode counts. */
#ifndef VIBSIM_ZALLOC_H
#define VIBSIM_ZALLOC_H

#include <stdlib.h>

enum { MOST = 100000 }; /* of anything in a scene or a mode */

#ifdef __cplusplus
/* Memory that goes into a pointer of any type, as in C. */
struct Memory {
    void *at;
    template <class T> operator T *() const { return static_cast<T *>(at); }
};
#else
typedef void *Memory;
#endif

static inline Memory zalloc(size_t count, size_t size)
{
#ifdef __cplusplus
    return Memory{calloc(count ? count : 1, size)};
#else
    return calloc(count ? count : 1, size);
#endif
}

/* `old`, grown to so many bytes, or NULL. */
static inline Memory regrown(void *old, size_t size)
{
#ifdef __cplusplus
    return Memory{realloc(old, size)};
#else
    return realloc(old, size);
#endif
}

#endif
