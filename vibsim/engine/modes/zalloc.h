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

/* In front of memory that has an owner, or is one: what was begun next. The rest of it only keeps what follows aligned. */
typedef union Piece {
    union Piece *next;
    char aligned[16];
} Piece;

/* Zeros that are freed with `owner`, which was begun so itself, without an owner; NULL without memory. */
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
#ifdef __cplusplus
    return Memory{realloc(old, size)};
#else
    return realloc(old, size);
#endif
}

#endif
