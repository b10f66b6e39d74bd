/* Functions that are to be made part of their callers, or kept apart from them, in the words of each compiler. */
#ifndef VIBSIM_INLINING_H
#define VIBSIM_INLINING_H

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#define APART static __attribute__((noinline))
#elif defined(_MSC_VER)
#define INLINE static __forceinline
#define APART static __declspec(noinline)
#else
#define INLINE static inline
#define APART static
#endif

/* In the body of a short loop whose numbers have just been written, or are read next, one by one: keeps it from being made one over
 * registers of several, which would wait until all of these numbers are in memory.
 */
#if defined(__GNUC__) && !defined(LIMBS)
#define ONE_BY_ONE __asm__("")
#else
#define ONE_BY_ONE (void)0
#endif

#endif
