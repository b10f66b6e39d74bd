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

#if LIMBS == 2 /* up to 32 digits, 107 bits; see `digits_in_c` in vibsim/engine/number_forms.py */
enum { MAX_ORDER = 40, SERIES_TERMS = 42 };
#elif LIMBS == 3 /* up to 51 digits, 170 bits */
enum { MAX_ORDER = 62, SERIES_TERMS = 56 };
#else /* up to 71 digits, 236 bits */
enum { MAX_ORDER = 86, SERIES_TERMS = 70 };
#endif
enum { NO_EXPONENT = -1000000, MOST_DECIMALS = 75 }; /* of zero; digits that are written */
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

#endif
