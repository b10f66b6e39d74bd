/* Arithmetic of whole numbers of some words, lowest first. */
#ifndef VIBSIM_WORDS_H
#define VIBSIM_WORDS_H

#include "limbs.h"

/* The number of `count` words that need not begin with a 1, its highest bit 2^(exponent - 1), cut off behind WORDS words. */
Real normal(uint64_t *w, int count, long exponent, int sign);

#ifdef WORDS_BY_RUN
#define ADD_WORDS(count, total, part) add_words(count, total, part)
#define SUBTRACT_WORDS(count, total, part) subtract_words(count, total, part)

STEP uint64_t add_words(int count, uint64_t *total, const uint64_t *part)
{
    unsigned char over = 0;
    for (int i = 0; i < count; i++) {
        const Wide sum = (Wide)total[i] + part[i] + over;
        total[i] = (uint64_t)sum;
        over = (unsigned char)(sum >> WORD);
    }
    return over;
}

STEP uint64_t subtract_words(int count, uint64_t *total, const uint64_t *part)
{
    unsigned char under = 0;
    for (int i = 0; i < count; i++) {
        const Wide left = (Wide)total[i] - part[i] - under;
        total[i] = (uint64_t)left;
        under = (unsigned char)(left >> WORD & 1);
    }
    return under;
}

/* s += a b, of three words. */
STEP void add_product(uint64_t *s, uint64_t a, uint64_t b)
{
#if defined(__x86_64__)
    __asm__("mulq %4\n\taddq %%rax, %0\n\tadcq %%rdx, %1\n\tadcq $0, %2"
            : "+r"(s[0]), "+r"(s[1]), "+r"(s[2]), "+a"(a)
            : "rm"(b)
            : "rdx", "cc");
#else
    const Wide product = (Wide)a * b;
    const unsigned char over = __builtin_add_overflow(s[0], (uint64_t)product, &s[0]);
    const Wide next = (product >> WORD) + s[1] + over;
    s[1] = (uint64_t)next;
    s[2] += (uint64_t)(next >> WORD);
#endif
}

/* As below, column by column: word k of the product is w[k - words + 1]. */
STEP void multiply_words(const uint64_t *a, const uint64_t *b, uint64_t *w)
{
    const int words = WORDS;
    uint64_t s[3] = {0, 0, 0};
    for (int k = words - 2; k < 2 * words - 1; k++) {
        const int first = k < words ? 0 : k - words + 1, last = k < words ? k : words - 1;
        const uint64_t *back = b + k;
        _Pragma("GCC unroll 4") for (int i = first; i <= last; i++)
            add_product(s, a[i], back[-i]);
        if (k >= words - 1)
            w[k - words + 1] = s[0];
        s[0] = s[1];
        s[1] = s[2];
        s[2] = 0;
    }
    w[words] = s[0];
}
#else
#define ADD_WORDS(count, total, part) add_words<count>(total, part)
#define SUBTRACT_WORDS(count, total, part) subtract_words<count>(total, part)

/* total += part in words from the lowest on; returns what is carried beyond them. gcc 12 makes twice as many instructions
 * of the loop as by hand, for three and four words, here and below.
 */
template <int COUNT> STEP uint64_t add_words(uint64_t *total, const uint64_t *part)
{
#if defined(__x86_64__)
    if constexpr (COUNT == 3) {
        uint64_t over = 0;
        __asm__("addq %4, %0\n\tadcq %5, %1\n\tadcq %6, %2\n\tadcq $0, %3"
                : "+&r"(total[0]), "+&r"(total[1]), "+&r"(total[2]), "+&r"(over)
                : "r"(part[0]), "r"(part[1]), "r"(part[2])
                : "cc");
        return over;
    }
    if constexpr (COUNT == 4) {
        uint64_t over = 0;
        __asm__("addq %5, %0\n\tadcq %6, %1\n\tadcq %7, %2\n\tadcq %8, %3\n\tadcq $0, %4"
                : "+&r"(total[0]), "+&r"(total[1]), "+&r"(total[2]), "+&r"(total[3]), "+&r"(over)
                : "r"(part[0]), "r"(part[1]), "r"(part[2]), "r"(part[3])
                : "cc");
        return over;
    }
#endif
    Wide over = 0;
    UNROLLED for (int i = 0; i < COUNT; i++) {
        over += (Wide)total[i] + part[i];
        total[i] = (uint64_t)over;
        over >>= WORD;
    }
    return (uint64_t)over;
}

/* total -= part; returns 1 where that is below 0, to which a power of 2 beyond the words is added then. */
template <int COUNT> STEP uint64_t subtract_words(uint64_t *total, const uint64_t *part)
{
#if defined(__x86_64__)
    if constexpr (COUNT == 4) {
        uint64_t under = 0;
        __asm__("subq %5, %0\n\tsbbq %6, %1\n\tsbbq %7, %2\n\tsbbq %8, %3\n\tadcq $0, %4"
                : "+&r"(total[0]), "+&r"(total[1]), "+&r"(total[2]), "+&r"(total[3]), "+&r"(under)
                : "r"(part[0]), "r"(part[1]), "r"(part[2]), "r"(part[3])
                : "cc");
        return under;
    }
    if constexpr (COUNT == 3) {
        uint64_t under = 0;
        __asm__("subq %4, %0\n\tsbbq %5, %1\n\tsbbq %6, %2\n\tadcq $0, %3"
                : "+&r"(total[0]), "+&r"(total[1]), "+&r"(total[2]), "+&r"(under)
                : "r"(part[0]), "r"(part[1]), "r"(part[2])
                : "cc");
        return under;
    }
#endif
    Wide left = 0;
    uint64_t under = 0;
    UNROLLED for (int i = 0; i < COUNT; i++) {
        left = (Wide)total[i] - part[i] - under;
        total[i] = (uint64_t)left;
        under = (uint64_t)(left >> WORD) & 1;
    }
    return under;
}

/* The upper words of a product of mantissas, w[0] of them below the lowest that counts; products that end below w[0] are left out. */
STEP void multiply_words(const uint64_t *a, const uint64_t *b, uint64_t *w)
{
    if constexpr (LIMBS == 2) {
        const Wide low = (Wide)a[0] * b[0], one = (Wide)a[0] * b[1], other = (Wide)a[1] * b[0];
        const Wide middle = (low >> WORD) + (uint64_t)one + (uint64_t)other;
        const Wide high = (Wide)a[1] * b[1] + (one >> WORD) + (other >> WORD) + (middle >> WORD);
        w[0] = (uint64_t)middle;
        w[1] = (uint64_t)high;
        w[2] = (uint64_t)(high >> WORD);
        return;
    }
    UNROLLED for (int i = 0; i < LIMBS; i++) { /* word k of the product is w[k - LIMBS + 1] */
        const int first = LIMBS - 2 - i > 0 ? LIMBS - 2 - i : 0;
        uint64_t over = 0;
        UNROLLED for (int j = 0; j < LIMBS; j++) {
            if (j < first)
                continue;
            if (i + j < LIMBS - 1) {
                over = (uint64_t)((Wide)a[i] * b[j] >> WORD);
                continue;
            }
            const Wide product = (Wide)a[i] * b[j] + (i > 0 ? w[i + j - LIMBS + 1] : 0) + over;
            w[i + j - LIMBS + 1] = (uint64_t)product;
            over = (uint64_t)(product >> WORD);
        }
        w[i + 1] = over;
    }
}
#endif

#endif
