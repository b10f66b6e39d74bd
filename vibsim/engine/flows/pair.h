/* Two doubles side by side: the odd and the even chain of a sum, in one vector register where the compiler has them.
 * Each lane is rounded by itself, as two scalars would be.
 */
#ifndef VIBSIM_PAIR_H
#define VIBSIM_PAIR_H

#include "real.h"

#if defined(__GNUC__) && !defined(LIMBS)
typedef Real Pair __attribute__((vector_size(16), aligned(8), may_alias));

static inline Pair load_pair(const Real *p)
{
    return *(const Pair *)p;
}

static inline void store_pair(Real *p, Pair pair)
{
    *(Pair *)p = pair;
}

static inline Pair add_product(Pair sum, Pair a, Pair b)
{
    return sum + a * b;
}

static inline Pair make_pair(Real first, Real second)
{
    Pair pair = {first, second};
    return pair;
}

static inline Pair add_pair(Pair a, Pair b)
{
    return a + b;
}

static inline Pair subtract_pair(Pair a, Pair b)
{
    return a - b;
}

static inline Pair multiply_pair(Pair a, Pair b)
{
    return a * b;
}

static inline Real first_of_pair(Pair pair)
{
    return pair[0];
}

static inline Real second_of_pair(Pair pair)
{
    return pair[1];
}
#else
typedef struct {
    Real first, second;
} Pair;

#ifdef WORDS_BY_RUN /* copies of numbers take as long as sums of theirs */
typedef const Pair &PairIn;
typedef const Real &RealIn;

static inline PairIn load_pair(const Real *p)
{
    return *(const Pair *)p;
}
#else
typedef Pair PairIn;
typedef Real RealIn;

static inline Pair load_pair(const Real *p)
{
    Pair pair = {p[0], p[1]};
    return pair;
}
#endif

static inline Pair make_pair(RealIn first, RealIn second)
{
    Pair pair = {first, second};
    return pair;
}

static inline void store_pair(Real *p, PairIn pair)
{
    p[0] = pair.first;
    p[1] = pair.second;
}

static inline Pair add_product(PairIn sum, PairIn a, PairIn b)
{
    Pair pair = {sum.first + a.first * b.first, sum.second + a.second * b.second};
    return pair;
}

static inline Pair add_pair(PairIn a, PairIn b)
{
    Pair pair = {a.first + b.first, a.second + b.second};
    return pair;
}

static inline Pair subtract_pair(PairIn a, PairIn b)
{
    Pair pair = {a.first - b.first, a.second - b.second};
    return pair;
}

static inline Pair multiply_pair(PairIn a, PairIn b)
{
    Pair pair = {a.first * b.first, a.second * b.second};
    return pair;
}

static inline Real first_of_pair(PairIn pair)
{
    return pair.first;
}

static inline Real second_of_pair(PairIn pair)
{
    return pair.second;
}
#endif

static inline Pair twice(Real value)
{
    return make_pair(value, value);
}

static inline Real sum_of_pair(Pair pair)
{
    return first_of_pair(pair) + second_of_pair(pair);
}

#endif
