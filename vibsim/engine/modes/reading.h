/* Reads packed integers and doubles one after another, never beyond their end. */
#ifndef VIBSIM_READING_H
#define VIBSIM_READING_H

#include "zalloc.h"

typedef struct {
    const int *ints;
    const Real *doubles;
    long int_count, double_count, next_int, next_double;
    int short_of; /* whether something was asked for beyond the end, an index was out of its range, or there was no memory */
    void *owner;  /* of the memory for what is read */
} Reader;

static inline int read_int(Reader *r)
{
    if (r->next_int < r->int_count)
        return r->ints[r->next_int++];
    r->short_of = 1;
    return 0;
}

static inline Real read_double(Reader *r)
{
    if (r->next_double < r->double_count)
        return r->doubles[r->next_double++];
    r->short_of = 1;
    return 0.0;
}

/* An integer from low to high. */
static inline int read_index(Reader *r, int low, int high)
{
    int value = read_int(r);
    if (value < low || value > high) {
        r->short_of = 1;
        return low;
    }
    return value;
}

/* Zeros for what is read, which are freed with its owner. */
static inline Memory room(Reader *in, size_t count, size_t size)
{
    void *at = zalloc_for(in->owner, count, size);
    in->short_of = in->short_of || !at;
    return MEMORY(at);
}

static inline int read_through(const Reader *r)
{
    return !r->short_of && r->next_int == r->int_count && r->next_double == r->double_count;
}

#endif
