/* Responses of one damped oscillator; twin of vibsim/flows/responses.py. */
#include "kernel.h"

#define QUARTER 0.25
#define SERIES_TERMS 400

void oscillator_set(Oscillator *o, double a, double b, double omega)
{
    double discriminant = b - a * a, fastest;
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
    fastest = o->w0 > omega ? o->w0 : omega;
    o->window = fastest > 0 ? 1.5 / fastest : INFINITY;
}

void release_and_impulse(const Oscillator *o, double t, double *release, double *impulse)
{
    double decay;
    if (o->oscillates) {
        double angle = o->wd * t;
        decay = exp(-(o->a * t));
        *impulse = angle != 0 ? decay * (sin(angle) / o->wd) : decay * t;
        *release = decay * cos(angle) + o->a * *impulse;
        return;
    }
    decay = exp(o->slow * t);
    *impulse = decay * (expm1(-(2 * (o->wd * t))) / -(2 * o->wd));
    *release = decay - o->slow * *impulse;
}

static void response_series(const Oscillator *o, double t, double omega, double *hc, double *hs)
{
    double damping = 2 * o->a * t, stiffness = o->b * (t * t), step = omega * t;
    double lr = t * t, li = 0, h0r = 0, h0i = 0, h1r = 0, h1i = 0, sr = 0, si = 0;
    int n;
    for (n = 0; n < SERIES_TERMS; n++) {
        double h2r = (lr - damping * (n + 1) * h1r - stiffness * h0r) / ((n + 2) * (n + 1));
        double h2i = (li - damping * (n + 1) * h1i - stiffness * h0i) / ((n + 2) * (n + 1));
        double last, lr_before = lr;
        sr = sr + h2r;
        si = si + h2i;
        last = fabs(h2r) + fabs(h2i) + fabs(h1r) + fabs(h1i);
        if (n >= 3 && last <= EPS / 4 * (fabs(sr) + fabs(si)))
            break;
        h0r = h1r;
        h0i = h1i;
        h1r = h2r;
        h1i = h2i;
        lr = -(li * step) / (n + 1);
        li = lr_before * step / (n + 1);
    }
    *hc = sr;
    *hs = si;
}

double constant_response(const Oscillator *o, double t, double release)
{
    double re, im;
    if (o->b * (t * t) >= QUARTER)
        return (1 - release) / o->b;
    if (!o->oscillates && o->wd * t >= 0.5) {
        double slow = o->slow != 0 ? expm1(o->slow * t) / o->slow : t;
        return (slow - expm1(o->fast * t) / o->fast) / (2 * o->wd);
    }
    response_series(o, t, 0, &re, &im);
    return re;
}

static void sinhc(double p, double q, double *re, double *im)
{
    double zz = p * p + q * q, nr, ni;
    if (zz == 0) {
        *re = 1;
        *im = 0;
        return;
    }
    nr = sinh(p) * cos(q);
    ni = cosh(p) * sin(q);
    *re = (nr * p + ni * q) / zz;
    *im = (ni * p - nr * q) / zz;
}

static void confluent(const Oscillator *o, double t, double cosine, double sine, double *hc, double *hs)
{
    double real1 = o->slow, imag1 = 0, real2 = o->fast, imag2 = 0;
    double p, q, mean, qr, qi, scale, mr, mi, e1r, e1i, decay, nr, ni, dr, di, dd, hr, hi;
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
    scale = t * exp(p);
    mr = cos(mean);
    mi = sin(mean);
    e1r = scale * (mr * qr - mi * qi);
    e1i = scale * (mr * qi + mi * qr);
    decay = exp(real2 * t);
    nr = decay * cos(imag2 * t) - cosine;
    ni = decay * sin(imag2 * t) - sine;
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

void harmonic_response(const Oscillator *o, double t, double release, double impulse, double cosine, double sine,
                       double *hc, double *hs)
{
    double square = t * t;
    if (o->zz * (square * square) >= QUARTER * QUARTER) {
        double nr = cosine - release, ni = sine - o->omega * impulse;
        *hc = (nr * o->zr + ni * o->zi) / o->zz;
        *hs = (ni * o->zr - nr * o->zi) / o->zz;
        return;
    }
    if (o->wd * t >= 0.5) {
        confluent(o, t, cosine, sine, hc, hs);
        return;
    }
    response_series(o, t, o->omega, hc, hs);
}

void free_harmonic_response(const Oscillator *point, double t, double cosine, double sine, double *hc, double *hs)
{
    double omega = point->omega, angle = omega * t;
    if (angle * angle >= QUARTER) {
        double square = omega * omega;
        *hc = (1 - cosine) / square;
        *hs = (angle - sine) / square;
        return;
    }
    response_series(point, t, omega, hc, hs);
}
