/* Certified first root of a polynomial event function; twin of vibsim/events/polynomial_root.py. */
#include "first_root.h"
#include "kernel.h"
#include "numbers.h"

#define MARCH_LIMIT 10000
#define PIECES 8
#define TURNING 60

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

/* Keep the minimum between two points, by safeguarded Newton steps on the slope. */
static void turn_between(Run *r, const double *series, const double *slopes, int count, double t0, double low, double high)
{
    double tau = low + (high - low) / 2, settled = (high - low) * power_of_two(binary_exponent(EPS) / 3.0);
    double value, slope = 0, curvature = 0, ahead = tau, unused;
    int i;
    for (i = 0; i < TURNING; i++) {
        value_and_slope(slopes, count - 1, tau, &slope, &curvature);
        if (slope < 0)
            low = tau;
        else
            high = tau;
        ahead = curvature > 0 ? tau - slope / curvature : low;
        if (curvature > 0 && fabs(ahead - tau) < settled)
            break;
        if (!(low < ahead && ahead < high))
            ahead = low + (high - low) / 2;
        tau = ahead;
    }
    value_and_slope(series, count, tau, &value, &unused);
    if (curvature > 0)
        value = value - slope * slope / (2 * curvature);
    value = value > 0 ? value : 0 * tau;
    if (value < r->margin) {
        r->margin = value;
        r->margin_time = t0 + ahead;
    }
}

static void watch_turns(Run *r, const double *series, int count, double t0, double stop)
{
    double slopes[SERIES], low = 0 * stop, falling, rising, unused;
    int n, i;
    for (n = 1; n < count; n++)
        slopes[n - 1] = n * series[n];
    falling = slopes[0];
    for (i = 1; i <= PIECES; i++) {
        double high = stop * i / PIECES;
        value_and_slope(slopes, count - 1, high, &rising, &unused);
        if (falling < 0 && 0 <= rising)
            turn_between(r, series, slopes, count, t0, low, high);
        low = high;
        falling = rising;
    }
}

static int may_turn(const double *series, int count, int order, double total, double swing, double h)
{
    if (order > 0)
        return order * series[0] <= swing + order * (total - series[0]);
    return count > 1 && 2 * fabs(series[1]) * h <= swing;
}

int polynomial_first_root(Run *r, const double *coefficients, int count, int known, double t0, double h, int keep_margin,
                          double *root)
{
    const double *series;
    double total, fall = 0.0, curvature = 0.0, swing = 0.0, power = h, noise;
    int order = known, n, found = 0;
    while (order < count && coefficients[order] == 0)
        order++;
    if (order == count)
        return 0;
    series = coefficients + order;
    total = fabs(series[0]);
    for (n = 1; n < count - order; n++) {
        double term = fabs(series[n]) * power;
        total = total + term;
        swing = swing + n * term;
        if (n > 1) {
            curvature = curvature + n * (n - 1) * term;
            fall = fall + term;
        } else if (series[1] < 0) {
            fall = fall + term;
        }
        power = power * h;
    }
    noise = 4 * EPS * total;
    if (series[0] - noise - fall <= 0)
        found = march(r, series, count - order, noise, curvature / (h * h), t0, h, root);
    if (keep_margin && series[0] - fall < r->margin && may_turn(series, count - order, order, total, swing, h))
        watch_turns(r, coefficients, count, t0, found ? *root - t0 : h);
    return found;
}
