/* Memory for what a scene or a mode counts. */
#ifndef VIBSIM_ZALLOC_H
#define VIBSIM_ZALLOC_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 100000 }; /* of anything in a scene or a mode */

#ifdef __cplusplus
/* Memory that goes into a pointer of any type, as in C. */
struct Memory {
    void *at;
    template <class T> operator T *() const { return static_cast<T *>(at); }
};
#define MEMORY(at) Memory{at}
#else
typedef void *Memory;
#define MEMORY(at) (at)
#endif

static inline Memory zalloc(size_t count, size_t size)
{
    return MEMORY(calloc(count ? count : 1, size));
}

enum { LINE = 64 }; /* bytes that a processor fetches at once: numbers begin at one, wherever the C library puts them */

/* In front of memory that has an owner, or is one: the next of all that is freed with it; where the C library has made it. */
typedef struct Piece {
    struct Piece *next;
    void *made;
} Piece;

/* Zeros that are freed with `owner`; the owner itself is made so too, with NULL for its own. NULL without memory. */
static inline void *zalloc_for(void *owner, size_t count, size_t size)
{
    char *made = (char *)calloc(1, sizeof(Piece) + LINE + count * size);
    Piece *piece = made ? (Piece *)(((uintptr_t)made + sizeof(Piece) + LINE - 1) / LINE * LINE) - 1 : NULL;
    if (piece)
        piece->made = made;
    if (piece && owner) {
        piece->next = ((Piece *)owner - 1)->next;
        ((Piece *)owner - 1)->next = piece;
    }
    return piece ? piece + 1 : NULL;
}

/* Free an owner with all that it owns; nothing where that is NULL. */
static inline void free_owner(void *owner)
{
    Piece *piece = owner ? (Piece *)owner - 1 : NULL, *next;
    for (; piece; piece = next) {
        next = piece->next;
        free(piece->made);
    }
}

/* Make room for `after` things of some size where there was room for `before`, zeros behind these; 0 without memory. */
static inline int grow(void **array, size_t before, size_t after, size_t size)
{
    char *more = (char *)realloc(*array, after * size);
    if (!more)
        return 0;
    memset(more + before * size, 0, (after - before) * size);
    *array = more;
    return 1;
}

#endif
