/* How many digits the orders of a series need that a motor's rotor takes part in, and those orders in doubles that need no more.
 *
 * Within a step terms fall from order to order, to the round-off of the run at the last one. So a coefficient of a later order needs as
 * many digits less as its term is smaller: sums of products take fewer digits (fixed_series.h), and from some order on the digits of
 * doubles suffice. Expansions of one mode are alike: each tells how the next one is to be made, and is made anew where that was wrong.
 */
#ifndef __clang__
#pragma GCC optimize("O2")
#endif
#include "engine.h"
#include "numbers.h"

#ifdef FIXED_SERIES
enum { SMALL_RATES = 3, SMALL_STRIDE = 6 }; /* of the tables of small scenes */
/* LONGER: H is at most so many steps. Bits: MARGIN: that bounds exceed what they were; SPARE: below the round-off; LOST: by all
 * roundings of the orders in doubles together; LEAST_TO_SPARE, MOST_TO_SPARE: of these, as steps of one mode are not all alike.
 */
enum { LONGER = 5, MARGIN = 2, SPARE = 4, DOUBLE_BITS = 53, LOST = 2, LEAST_TO_SPARE = 2, MOST_TO_SPARE = 7 };

/* Binary exponents of what bounds |a_n| H^n, and of the largest of the first of them; a[n * step]: order n. */
static void bounds_of(const Real *a, int step, int order, int power, long *most, long *leading)
{
    int n;
    *most = *leading = LONG_MIN;
    for (n = 0; n < order; n++) {
        const Real *one = a + n * step;
        const long size = one->sign ? one->exponent + (long)n * power : LONG_MIN;
        *leading = n < LEADING_TERMS && size > *leading ? size : *leading;
        *most = size > *most ? size : *most;
    }
}

/* By how many bits the bounds of the factors of a product of the rotor exceed their first coefficients at most, by what the series
 * are; `bound` of those where it is given. -1 where there is none.
 */
static long slack_of(const Taylor *f, int power, const int *bound, int *found)
{
    const Real *series[BLOCKS] = {f->cosine, f->sine, f->w_back + f->order, f->a1_back + f->order};
    long above[BLOCKS], most, leading, of_speeds, of_thrusts;
    int s;
    for (s = 0; s < BLOCKS; s++) {
        bounds_of(series[s], s < SPEEDS ? 1 : -1, f->order, power, &most, &leading);
        if (leading == LONG_MIN || most > FURTHEST)
            return -1;
        if (found)
            found[s] = (int)most + MARGIN;
        above[s] = (bound ? bound[s] : found[s]) - leading;
    }
    of_speeds = (above[COSINES] > above[SINES] ? above[COSINES] : above[SINES]) + above[SPEEDS];
    of_thrusts = above[SINES] + above[THRUSTS];
    return of_speeds > of_thrusts ? of_speeds : of_thrusts;
}

/* Whether sums of products in whole numbers were as right as the round-off asks for. */
static bool digits_sufficed(const Taylor *f)
{
    const Scales<SERIES> *s = f->scales;
    long slack;
    if (!s || !isfinite(f->h) || logarithm((double)f->h) * PER_LN_2 > s->power - s->gap)
        return false;
    slack = slack_of(f, s->power, s->bound, NULL);
    return slack >= 0 && slack <= s->slack;
}

/* How many orders the next expansion in this mode takes in words, by those of this one and the bits that its others had to spare. */
static int orders_in_words(const Taylor *f, int words, double spare)
{
    const int p = f->order, bits = 1 - unit_roundoff.exponent;
    if (words == 0)
        return p - p * (DOUBLE_BITS - SPARE - LOST - LEAST_TO_SPARE) / bits;
    if (f->rest.first == 0)
        return words;
    if (spare < 0 && spare > -bits)
        words = f->rest.first + 2 - (int)(spare * p / bits);
    else
        words = f->rest.first + (spare < 0 ? 2 : spare < (int)LEAST_TO_SPARE ? 1 : spare > (int)MOST_TO_SPARE ? -1 : 0);
    return words < 2 ? 2 : words < p ? words : p;
}

/* Digits for the next expansion in this mode, by this one and what `bits_to_spare` tells of it; as they are where that went well. */
void set_digits(Run *r, double spare)
{
    Taylor *f = &r->taylor;
    Scales<SERIES> *s = &r->mode->scales;
    const int bits = 1 - unit_roundoff.exponent;
    double size;
    long slack;
    int n;
    if (f->scales && spare >= (int)LEAST_TO_SPARE && spare <= (int)MOST_TO_SPARE && logarithm((double)f->h) * PER_LN_2 > s->power - s->gap - 1)
        return;
    s->words = orders_in_words(f, s->most ? s->words : 0, spare);
    s->most = 0;
    if (!isfinite(f->h) || f->h <= 0)
        return;
    size = logarithm((int)LONGER * (double)f->h) * PER_LN_2;
    s->power = (int)floor(size);
    s->gap = s->power - size + 1.8; /* the next step may be longer by sqrt(2) */
    slack = slack_of(f, s->power, NULL, s->bound);
    if (slack < 0 || slack + bits + SPARE + MARGIN > DIGIT * MOST_DIGITS)
        return;
    s->slack = (int)slack + MARGIN;
    s->most = bits + SPARE + s->slack <= DIGIT * LIMBS ? LIMBS : MOST_DIGITS;
    for (n = 0; n <= f->order; n++) {
        const int needed = bits + SPARE + s->slack - (int)(s->gap * n), digits = (needed + DIGIT - 1) / DIGIT;
        s->digits[n] = (unsigned char)(digits < 1 ? 1 : digits < s->most ? digits : s->most);
    }
}

/* Sum of a_i b_(last - i), i from `first` on, or with `sizes` of their sizes. */
STEP double sum_of(const double *a, const double *b, int first, int last, bool sizes)
{
    double even = 0, odd = 0;
    int i;
    for (i = first; i < last; i += 2) {
        const double one = a[i] * b[last - i], other = a[i + 1] * b[last - i - 1];
        even += sizes ? fabs(one) : one;
        odd += sizes ? fabs(other) : other;
    }
    if (i == last)
        even += sizes ? fabs(a[i] * b[0]) : a[i] * b[0];
    return even + odd;
}

/* See engine.h. Coefficient n is taken times H^n, H = 2^power. Whether doubles sufficed is told by the rounding of the first of these orders,
 * whose terms are the largest: there the sizes of all that is summed are summed too.
 */
void last_orders(Run *r, int first, int bodies, int moving, int far)
{
    Taylor *f = &r->taylor;
    const Mode *m = r->mode;
    const int p = f->order, phi = bodies, power = f->scales->power;
    const double H = double_of((uint64_t)(power + 1023) << 52), k = (double)m->small.k, c = (double)m->small.c;
    const double unbalance = (double)r->unbalance, drag = (double)r->drag, mobility_far = moving > 1 ? (double)m->mobility[1] : 0;
    const double s0 = in_double(f->sine[0], 0), mass = (double)(m->carried + r->m3), inertia = (double)r->inertia;
    const double coupling = unbalance * s0, inverse_det = 1 / (mass * inertia - coupling * coupling);
    const double to_a1 = inertia * inverse_det, to_w = mass * inverse_det, cross = coupling * inverse_det;
    const Real *load = f->loaded_on[0], *load_far = moving > 1 ? f->loaded_on[1] : NULL;
    double cosine[SERIES], sine[SERIES], w[SERIES], a1[SERIES], x, x_far, v, v_far, sw;
    Real *row = f->table + first * SMALL_STRIDE;
    int n;
    for (n = 0; n <= first; n++) {
        cosine[n] = in_double(f->cosine[n], (long)n * power);
        sine[n] = in_double(f->sine[n], (long)n * power);
        w[n] = in_double(f->w_back[p - n], (long)n * power);
        if (n < first)
            a1[n] = in_double(f->a1_back[p - n], (long)n * power);
    }
    x = in_double(row[0], (long)first * power);
    v = in_double(row[SMALL_RATES], (long)first * power);
    x_far = in_double(row[far], (long)first * power);
    v_far = in_double(row[SMALL_RATES + far], (long)first * power);
    sw = sum_of(sine, w, 0, first, false);
    for (n = first; n < p; n++, row += SMALL_STRIDE) {
        Real *next = row + SMALL_STRIDE, *rates = next + SMALL_RATES;
        const double inverse = H / (n + 1), rotation = unbalance * (n + 1) / H;
        const long down = -(long)power * (n + 1);
        double tail, torque, force, F, F_far, thrust;
        cosine[n + 1] = -sw * inverse;
        sine[n + 1] = sum_of(cosine, w, 0, n, false) * inverse;
        tail = sum_of(sine, w, 1, n + 1, false);
        torque = unbalance * sum_of(sine, a1, 1, n, false) - drag * w[n];
        force = k * (x - x_far) + c * (v - v_far);
        F = (load ? in_double(load[n], (long)n * power) : 0) - force;
        F_far = (load_far ? in_double(load_far[n], (long)n * power) : 0) + force;
        thrust = F + rotation * tail;
        a1[n] = to_a1 * thrust + cross * torque;
        w[n + 1] = (to_w * torque + cross * thrust) * inverse;
        if (n == first) {
            const double tails = sum_of(sine, w, 1, n + 1, true);
            const double forces = fabs(k) * (fabs(x) + fabs(x_far)) + fabs(c) * (fabs(v) + fabs(v_far)) + fabs(F + force);
            const double thrusts = forces + rotation * tails, torques = unbalance * sum_of(sine, a1, 1, n, true) + drag * fabs(w[n]);
            f->rest.terms[OF_COSINE] = tails * inverse;
            f->rest.terms[OF_SINE] = sum_of(cosine, w, 0, n, true) * inverse;
            f->rest.terms[OF_SPEED] = (to_w * torques + fabs(cross) * thrusts) * inverse;
            f->rest.terms[OF_RATE] = (to_a1 * thrusts + fabs(cross) * torques) * inverse;
            f->rest.terms[OF_RATE_FAR] = (forces + fabs(F_far - force)) * mobility_far * inverse;
        }
        sw = tail + sine[0] * w[n + 1];
        x = v * inverse;
        v = a1[n] * inverse;
        x_far = v_far * inverse;
        v_far = F_far * mobility_far * inverse;
        f->cosine[n + 1] = scaled(Real(cosine[n + 1]), down);
        f->sine[n + 1] = scaled(Real(sine[n + 1]), down);
        f->w_back[p - n - 1] = rates[phi] = scaled(Real(w[n + 1]), down);
        f->a1_back[p - n] = scaled(Real(a1[n]), -(long)power * n);
        next[0] = scaled(Real(x), down);
        rates[0] = scaled(Real(v), down);
        next[phi] = scaled(Real(w[n] * inverse), down);
        if (bodies > 1) {
            next[far] = scaled(Real(x_far), down);
            rates[far] = scaled(Real(v_far), down);
        }
    }
    f->rest.first = first;
}

/* Size of the first coefficients of a series within the step h, a[n * step]: order n. */
static double leading_of(const Real *a, int step, double h)
{
    double most = 0, power = 1;
    int n;
    for (n = 0; n < LEADING_TERMS; n++, power *= h) {
        const double size = fabs((double)a[n * step]) * power;
        most = size > most ? size : most;
    }
    return most;
}

/* How many bits the rounding of an expansion by `scales` is below what the run asks for: of the orders in doubles; below 0 where it is
 * above, or sums in whole numbers were not right.
 */
double bits_to_spare(const Run *r)
{
    const Taylor *f = &r->taylor;
    const double h = (double)f->h, *terms = f->rest.terms;
    const Real *rates = f->table + SMALL_RATES;
    const double leading[RESTS] = {leading_of(f->cosine, 1, h), leading_of(f->sine, 1, h), leading_of(f->w_back + f->order, -1, h),
                                   leading_of(rates, SMALL_STRIDE, h), r->bodies > 1 ? leading_of(rates + 1, SMALL_STRIDE, h) : 0};
    double room = INFINITY;
    int i;
    if (!digits_sufficed(f))
        return -INFINITY;
    if (f->rest.first == 0)
        return LEAST_TO_SPARE;
    for (i = 0; i < RESTS; i++) {
        if (terms[i] != 0 && !(terms[i] * room <= leading[i]))
            room = leading[i] / terms[i];
        if (!(room > 0))
            return -INFINITY;
    }
    room = (room < INFINITY ? logarithm(room) * PER_LN_2 : 1000.0) + (f->rest.first + 1) * (f->scales->power - logarithm(h) * PER_LN_2);
    return room + ((int)DOUBLE_BITS - LOST - SPARE - (1 - unit_roundoff.exponent));
}
#endif
