/* Certified first root of a polynomial event function; twin of vibsim/events/polynomial_root.py. */
#include "first_root.h"
#include "kernel.h"

#define MARCH_LIMIT 10000

static void value_and_slope(const double *series, int count, double tau, double *value, double *slope)
{
    double v = series[count - 1], s = series[count - 1] * 0;
    int n;
    for (n = count - 2; n >= 0; n--) {
        s = s * tau + v;
        v = v * tau + series[n];
    }
    *value = v;
    *slope = s;
}

static int march(Run *r, const double *series, int count, double noise, double bound, double t0, double h, double *root)
{
    double t = t0, stall = 1.0;
    int i;
    for (i = 0; i < MARCH_LIMIT; i++) {
        double tau = t - t0, value, slope, room, step, ahead;
        if (tau > h)
            return 0;
        value_and_slope(series, count, tau, &value, &slope);
        if (value < -noise || (value <= noise && slope <= 0)) {
            *root = t;
            return 1;
        }
        room = value > noise ? value - noise : 0.0;
        step = safe_step(room, slope, bound);
        if (step > h)
            return 0;
        ahead = t0 + (tau + step);
        if (ahead <= t) {
            if (slope < 0) {
                *root = t;
                return 1;
            }
            r->uncertified += 1;
            ahead = t + (nextafter(t, INFINITY) - t) * stall;
            stall = stall * 2;
        } else {
            stall = 1.0;
        }
        t = ahead;
    }
    r->uncertified += 1;
    return 0;
}

static void graze(Run *r, const double *series, int count, double t0, double h)
{
    double slopes[SERIES], first = series[1], last, value, tau;
    int n, i;
    value_and_slope(series, count, h, &value, &last);
    if (!(first < 0 && 0 <= last))
        return;
    tau = h * (first / (first - last));
    for (n = 1; n < count; n++)
        slopes[n - 1] = n * series[n];
    for (i = 0; i < 3; i++) {
        double slope, curvature;
        value_and_slope(slopes, count - 1, tau, &slope, &curvature);
        if (curvature <= 0)
            break;
        tau = tau - slope / curvature;
        tau = tau < 0 ? 0 * h : tau > h ? h : tau;
    }
    value_and_slope(series, count, tau, &value, &last);
    value = value > 0 ? value : 0 * h;
    if (value < r->margin) {
        r->margin = value;
        r->margin_time = t0 + tau;
    }
}

int polynomial_first_root(Run *r, const double *coefficients, int count, int known, double t0, double h, int keep_margin,
                          double *root)
{
    const double *series;
    double total, fall = 0.0, curvature = 0.0, power = h, noise;
    int order = known, n, turn, found = 0;
    while (order < count && coefficients[order] == 0)
        order++;
    if (order == count)
        return 0;
    series = coefficients + order;
    total = fabs(series[0]);
    for (n = 1; n < count - order; n++) {
        double term = fabs(series[n]) * power;
        total = total + term;
        if (n > 1) {
            curvature = curvature + n * (n - 1) * term;
            fall = fall + term;
        } else if (series[1] < 0) {
            fall = fall + term;
        }
        power = power * h;
    }
    turn = count - order > 1 && series[1] < 0 && curvature > fabs(series[1]) * h;
    noise = 4 * EPS * total;
    if (series[0] - noise - fall <= 0)
        found = march(r, series, count - order, noise, curvature / (h * h), t0, h, root);
    if (!found && keep_margin && turn)
        graze(r, coefficients, count, t0, h);
    return found;
}
