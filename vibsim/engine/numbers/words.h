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

/* As below. */
STEP void multiply_words(const uint64_t *a, const uint64_t *b, uint64_t *w)
{
    const int words = WORDS;
    w[0] = 0;
    for (int i = 0; i < words; i++) { /* word k of the product is w[k - words + 1] */
        int j = words - 2 - i;
        uint64_t over = 0;
        if (j >= 0)
            over = (uint64_t)((Wide)a[i] * b[j] >> WORD);
        for (j = j < 0 ? 0 : j + 1; j < words; j++) {
            const Wide product = (Wide)a[i] * b[j] + w[i + j - words + 1] + over;
            w[i + j - words + 1] = (uint64_t)product;
            over = (uint64_t)(product >> WORD);
        }
        w[i + 1] = over;
    }
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
