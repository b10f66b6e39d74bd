/* Numbers of words as decimal text, rounded once; as `decimal_text` in vibsim/physics/numbers.py but for its ties. */
#ifndef __clang__
#pragma GCC optimize("O2") /* of every number that a run writes */
#endif
#include "words.h"

#include "real.h"

enum { FIVES = 27, MOST_FIVES = MOST_DECIMALS + 265, ROOM = LIMBS + 2 + MOST_FIVES / FIVES, PART = 19 }; /* 5^27 and 10^19 go into a word */

static const uint64_t TEN_TO_PART = 10000000000000000000u, FIVE_TO_FIVES = 7450580596923828125u;

/* w *= factor; returns the number of words by then. */
STEP int times(uint64_t *w, int count, uint64_t factor)
{
    uint64_t over = 0;
    for (int i = 0; i < count; i++) {
        const Wide product = (Wide)w[i] * factor + over;
        w[i] = (uint64_t)product;
        over = (uint64_t)(product >> WORD);
    }
    if (over)
        w[count++] = over;
    return count;
}

/* w = w / 2^shift, to the nearest whole number, to the even one of two; returns the number of words. */
static int halved(uint64_t *w, int count, long shift)
{
    const int words = (int)(shift / WORD), bits = (int)(shift % WORD), half = (int)((shift - 1) / WORD), left = count - words;
    const int up = w[half] >> (shift - 1) % WORD & 1;
    bool behind = (w[half] & (((uint64_t)1 << (shift - 1) % WORD) - 1)) != 0;
    int i;
    for (i = 0; i < half; i++)
        behind = behind || w[i] != 0;
    for (i = 0; i < left; i++) {
        const uint64_t high = i + words + 1 < count ? w[i + words + 1] : 0;
        w[i] = w[i + words] >> bits | high << 1 << (WORD - 1 - bits);
    }
    if (up && (behind || (w[0] & 1)))
        for (i = 0; i < left && ++w[i] == 0; i++)
            ;
    return left;
}

/* Decimal digits of a whole number into text, behind so many of them; returns their number. */
static int write_digits(uint64_t *w, int count, char *text, int room)
{
    int at = room;
    while (count > 0 && w[count - 1] == 0)
        count--;
    while (count > 0) {
        uint64_t rest = 0;
        for (int i = count - 1; i >= 0; i--) {
            const Wide part = (Wide)rest << WORD | w[i];
            w[i] = (uint64_t)(part / TEN_TO_PART);
            rest = (uint64_t)(part % TEN_TO_PART);
        }
        while (count > 0 && w[count - 1] == 0)
            count--;
        for (int i = 0; i < PART && (count > 0 || rest > 0) && at > 0; i++) {
            text[--at] = (char)('0' + rest % 10);
            rest /= 10;
        }
    }
    return room - at;
}

/* The text of x as "-4.98...e-3"; false where it is not finite, or too large or small for the words at hand. */
static bool text_of(const Real &x, int digits, char *out)
{
    char text[MOST_DECIMALS + 53];
    uint64_t size;
    int power = (int)::floor((x.exponent - 1) * 0.30102999566398120), fives, found = 0;
    if (x.exponent == ENDLESS)
        return false;
    if (x.sign == 0) {
        memset(out, '0', (size_t)digits + 1);
        out[1] = '.';
        memcpy(out + digits + 1, "e+00", 4);
        return true;
    }
    for (int i = 0; i < 2; i++, power++) { /* the power is right, or one too low */
        uint64_t w[ROOM];
        int count = WORDS;
        long shift;
        fives = digits - 1 - power;
        shift = (long)LIMB_BITS - x.exponent - fives;
        if (fives < 0 || fives > MOST_FIVES || shift < 1)
            return false;
        memcpy(w, x.words(), sizeof *w * (size_t)count);
        for (; fives >= FIVES; fives -= FIVES)
            count = times(w, count, FIVE_TO_FIVES);
        for (uint64_t factor = 1; fives > 0; fives--) {
            factor *= 5;
            if (fives == 1)
                count = times(w, count, factor);
        }
        found = write_digits(w, halved(w, count, shift), text, (int)sizeof text);
        if (found <= digits)
            break;
    }
    if (found != digits)
        return false;
    if (x.sign < 0)
        *out++ = '-';
    *out++ = text[sizeof text - (size_t)digits];
    *out++ = '.';
    memcpy(out, text + sizeof text - (size_t)digits + 1, (size_t)digits - 1);
    out += digits - 1;
    *out++ = 'e';
    *out++ = power < 0 ? '-' : '+';
    size = (uint64_t)(power < 0 ? -power : power);
    found = write_digits(&size, 1, text, (int)sizeof text);
    if (found == 0)
        *out++ = '0';
    memcpy(out, text + sizeof text - (size_t)found, (size_t)found);
    return true;
}

bool decimal_texts(const Real *x, long count, int digits, int width, char *out)
{
    memset(out, 0, (size_t)count * (size_t)width);
    for (long i = 0; i < count; i++)
        if (!text_of(x[i], digits, out + i * width))
            return false;
    return true;
}
