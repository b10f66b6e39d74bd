/* Real, the type of the numbers of the motion: doubles, or where LIMBS is defined numbers of so many words (limbs.h).
 *
 * The engine is written once for both. As C it is the engine of doubles; as C++ with LIMBS the one for runs of many digits, where
 * +, -, * and / are those of the type. Whatever depends on how many digits a number has stands here.
 */
#ifndef VIBSIM_REAL_H
#define VIBSIM_REAL_H

#include "elementary.h"

#ifdef __cplusplus
#define restrict __restrict
#endif

#ifdef LIMBS
#include "limbs.h"
#include "limbs_functions.h"

#ifdef WORDS_BY_RUN /* up to 1000 digits, 3342 bits; loops go over what the run in hand needs */
#define MAX_ORDER most_order
#define SERIES_TERMS series_terms
#elif LIMBS == 2 /* up to 32 digits, 107 bits; see `digits_in_c` in vibsim/physics/precision.py */
enum { MAX_ORDER = 40, SERIES_TERMS = 42 };
#elif LIMBS == 3 /* up to 51 digits, 170 bits */
enum { MAX_ORDER = 62, SERIES_TERMS = 56 };
#else /* up to 71 digits, 236 bits */
enum { MAX_ORDER = 86, SERIES_TERMS = 70 };
#endif
enum { NO_EXPONENT = -1000000 }; /* of zero */
#ifdef WORDS_BY_RUN
enum { MOST_DECIMALS = 1005 }; /* digits that are written */
#else
enum { MOST_DECIMALS = 75 };
#define FIXED_SERIES /* there are sums of series in whole numbers, fixed_series.h */
#endif
#define TURN (2 * HALF_TURN)
#define EPS unit_roundoff /* above the rounding of the type, as of the numbers of Python that it stands for */
#else
typedef double Real;
#define MAX_ORDER 40
#define SERIES_TERMS 26
#define NO_EXPONENT (-2000)
#define TURN TWO_PI
#define EPS 1.1102230246251565e-16 /* 2^-53, unit round-off */
#endif

#define SERIES (MAX_ORDER + 2)

/* Room for the coefficients of a Taylor series that a function needs while it runs: on the stack but where there may be half a
 * megabyte of them, as a thread of its own may have no more than that.
 */
#ifdef WORDS_BY_RUN
class Series
{
    Real *const at;

  public:
    Series();
    ~Series();
    Series(const Series &) = delete;
    operator Real *() { return at; }
};
#else
typedef Real Series[SERIES];
#endif

#endif
