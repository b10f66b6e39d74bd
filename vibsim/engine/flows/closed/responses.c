/* Responses of one damped oscillator, accurate for every damping, stiffness, load frequency and time.
 *
 * The oscillator is y'' + 2 a y' + b y = load, with roots r1, r2 of r^2 + 2 a r + b = 0. Everything a mode of the ideal source
 * needs is
 *     S(t)   impulse response, S(0) = 0, S'(0) = 1            (first divided difference of exp at r1, r2)
 *     C(t)   release from y = 1 at rest                        (C' = -b S, S' = C - 2 a S)
 *     I(t)   response to the constant load 1, I' = S
 *     H(t)   response to the load exp(i omega t), H' = S + i omega H
 * I and H start at rest. Where the textbook quotients cancel (b -> 0, resonance, short times) they are taken as nested divided
 * differences or as power series, so that each response keeps full relative accuracy.
 */
#include "engine.h"
#include "numbers.h"
#include "responses.h"

/* Coefficients g_n of H = t^2 sum g_n (rate t)^n, real and imaginary. From H'' + 2 a H' + b H = exp(i omega t): (n + 2)(n + 1) g_n
 * = (i omega / rate)^n / n! - 2 (a / rate) (n + 1) g_(n-1) - (b / rate^2) g_(n-2).
 */
static void series_coefficients(const Oscillator *o, Real omega, Real *real, Real *imag)
{
    Real rate = o->rate > 0 ? o->rate : 1.0;
    Real damping = 2 * (o->a / rate), stiffness = (o->b / rate) / rate, step = omega / rate;
    Real r0 = 0, r1 = 0, i0 = 0, i1 = 0, lr = 1, li = 0;
    int n;
    for (n = 0; n < SERIES_TERMS; n++) {
        int divisor = (n + 2) * (n + 1);
        Real lr_before = lr;
        real[n] = (lr - damping * (n + 1) * r1 - stiffness * r0) / divisor;
        imag[n] = (li - damping * (n + 1) * i1 - stiffness * i0) / divisor;
        r0 = r1;
        r1 = real[n];
        i0 = i1;
        i1 = imag[n];
        lr = -(li * step) / (n + 1);
        li = lr_before * step / (n + 1);
    }
}

/* Constants of an oscillator under a load of frequency omega. Of a free mass only its damping sets a pace. `near` is |r1 - i
 * omega|^2 far above critical damping.
 */
void oscillator_set(Oscillator *o, Real a, Real b, Real omega)
{
    Real discriminant = b - a * a, fastest, pace, near;
    o->a = a;
    o->b = b;
    o->omega = omega;
    o->w0 = sqrt(b);
    o->oscillates = discriminant >= 0;
    o->wd = sqrt(fabs(discriminant));
    o->slow = o->fast = 0.0;
    if (!o->oscillates) {
        o->fast = -(a + o->wd);
        o->slow = b / o->fast;
    }
    o->zr = b - omega * omega;
    o->zi = 2 * a * omega;
    o->zz = o->zr * o->zr + o->zi * o->zi;
    near = o->slow * o->slow + omega * omega;
    o->settling = o->oscillates ? b : o->slow * o->slow;
    o->beating = o->oscillates ? o->zz : near * near;
    o->per_b = b > 0 ? 1 / b : 0.0;
    o->per_wd = o->wd > 0 ? 1 / o->wd : 0.0;
    o->inverse_r = o->zz > 0 ? o->zr / o->zz : 0.0;
    o->inverse_i = o->zz > 0 ? o->zi / o->zz : 0.0;
    fastest = o->w0 > omega ? o->w0 : omega;
    pace = fastest > 0 ? fastest : 2 * a;
    o->window = pace > 0 ? 1.5 / pace : UNHURRIED;
    o->rate = a > fastest ? a : fastest;
    series_coefficients(o, 0.0, o->steady_series, o->imag_series);
    series_coefficients(o, omega, o->real_series, o->imag_series);
}

/* Real and imaginary part of sinh(z) / z for z = p + i q. */
static void sinhc(Real p, Real q, Real *re, Real *im)
{
    Real zz = p * p + q * q, sine, cosine, nr, ni;
    if (zz == 0) {
        *re = 1;
        *im = 0;
        return;
    }
    sine_cosine(q, &sine, &cosine);
    nr = hyperbolic_sine(p) * cosine;
    ni = hyperbolic_cosine(p) * sine;
    *re = (nr * p + ni * q) / zz;
    *im = (ni * p - nr * q) / zz;
}

/* H near resonance: (E1 - E2) / (r1 - r2) with E_k = (exp(r_k t) - exp(i omega t)) / (r_k - i omega). E1 = t exp((r1 + i omega) t
 * / 2) sinhc((r1 - i omega) t / 2) holds up to the resonance itself (secular growth).
 */
void confluent_response(const Oscillator *o, Real t, Real cosine, Real sine, Real *hc, Real *hs)
{
    Real real1 = o->slow, imag1 = 0, real2 = o->fast, imag2 = 0;
    Real p, q, mean, qr, qi, scale, mr, mi, e1r, e1i, decay, turned_sine, turned_cosine, nr, ni, dr, di, dd, hr, hi;
    if (o->oscillates) {
        real1 = -o->a;
        imag1 = o->wd;
        real2 = -o->a;
        imag2 = -o->wd;
    }
    p = real1 * t / 2;
    q = (imag1 - o->omega) * t / 2;
    mean = (imag1 + o->omega) * t / 2;
    sinhc(p, q, &qr, &qi);
    scale = t * exponential(p);
    sine_cosine(mean, &mi, &mr);
    e1r = scale * (mr * qr - mi * qi);
    e1i = scale * (mr * qi + mi * qr);
    decay = exponential(real2 * t);
    sine_cosine(imag2 * t, &turned_sine, &turned_cosine);
    nr = decay * turned_cosine - cosine;
    ni = decay * turned_sine - sine;
    dr = real2;
    di = imag2 - o->omega;
    dd = dr * dr + di * di;
    hr = e1r - (nr * dr + ni * di) / dd;
    hi = e1i - (ni * dr - nr * di) / dd;
    if (o->oscillates) {
        *hc = hi / (2 * o->wd);
        *hs = -hr / (2 * o->wd);
        return;
    }
    *hc = hr / (2 * o->wd);
    *hs = hi / (2 * o->wd);
}
