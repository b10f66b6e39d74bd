/* Reads packed integers and doubles one after another, never beyond their end. */
#ifndef VIBSIM_READING_H
#define VIBSIM_READING_H

typedef struct {
    const int *ints;
    const Real *doubles;
    long int_count, double_count, next_int, next_double;
    int short_of; /* whether something was asked for beyond the end, or an index was out of its range */
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

static inline int read_through(const Reader *r)
{
    return !r->short_of && r->next_int == r->int_count && r->next_double == r->double_count;
}

#endif
