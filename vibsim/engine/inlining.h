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

#endif
