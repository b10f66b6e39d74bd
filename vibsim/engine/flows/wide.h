/* Loops over many equal operations, built twice where the loader can choose: for every processor, and for those with four doubles
 * in a register. Each lane is rounded by itself, so both give the same bits; the build forbids fused products and sums.
 */
#ifndef VIBSIM_WIDE_H
#define VIBSIM_WIDE_H

#include <stdlib.h> /* tells which C library this is */

#if !defined(LIMBS) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#define WIDE_WITH_CALLS WIDE __attribute__((flatten)) /* with all that the function calls in it */
#else
#define WIDE
#define WIDE_WITH_CALLS
#endif

#ifdef __GNUC__
#define ALIGNED(bytes) __attribute__((aligned(bytes)))
#define VECTOR(count) __attribute__((vector_size(8 * (count)), may_alias)) /* of so many doubles, or whole numbers of 64 bits */
#else
#define ALIGNED(bytes)
#endif

#define DOUBLES_AT_ONCE 4 /* doubles in a register, or a multiple; TIMES_AT_ONCE is a multiple of it */

#endif
