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
#define MEMORY(at) Memory{at}
#else
typedef void *Memory;
#define MEMORY(at) (at)
#endif

static inline Memory zalloc(size_t count, size_t size)
{
    return MEMORY(calloc(count ? count : 1, size));
}

/* In front of memory that has an owner, or is one: the next of all that is freed with it. The rest keeps what follows aligned. */
typedef union Piece {
    union Piece *next;
    char aligned[16];
} Piece;

/* Zeros that are freed with `owner`; the owner itself is made so too, with NULL for its own. NULL without memory. */
static inline void *zalloc_for(void *owner, size_t count, size_t size)
{
    Piece *piece = (Piece *)calloc(1, sizeof *piece + count * size);
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
        free(piece);
    }
}

/* `old`, grown to so many bytes, or NULL. */
static inline Memory regrown(void *old, size_t size)
{
    return MEMORY(realloc(old, size));
}

#endif
