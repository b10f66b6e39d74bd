/* Room for what a scene or a mode counts. */
#ifndef VIBSIM_ROOM_H
#define VIBSIM_ROOM_H

#include <stdlib.h>

enum { MOST = 100000 }; /* of anything in a scene or a mode */

static inline void *room(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}

#endif
