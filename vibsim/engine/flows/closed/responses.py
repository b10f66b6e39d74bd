"""Responses of one damped oscillator, accurate for every damping, stiffness, load frequency and time.

The oscillator is y'' + 2 a y' + b y = load, with roots r1, r2 of r^2 + 2 a r + b = 0. Everything a mode of
the ideal source needs is
    S(t)   impulse response, S(0) = 0, S'(0) = 1            (first divided difference of exp at r1, r2)
    C(t)   release from y = 1 at rest                        (C' = -b S, S' = C - 2 a S)
    I(t)   response to the constant load 1, I' = S
    H(t)   response to the load exp(i omega t), H' = S + i omega H
I and H start at rest. Where the textbook quotients cancel (b -> 0, resonance, short times) they are taken as
nested divided differences or as power series, so that each response keeps full relative accuracy.
"""

from functools import cached_property
from typing import Generic

from vibsim.physics.numbers import Kit, N, abs, horner

Responses = tuple[N, N, N, N]  # Re H, Im H [s^2] and their rates [s]

# Quotients by b and by Z = (r1 - i omega)(r2 - i omega) cancel at most three bits where |Z| t^2 is above a
# quarter; far above critical damping, where r2 t is large whatever r1 t is, where |r1 - i omega| t is above
# a half.
QUARTER = 0.25
# After many turns close to resonance the phases of C and S, rounded to eps w t, come out of the quotient over
# |r1 - i omega| t, which is small.
RESONANT = 0.01
UNHURRIED = 1e100  # window of a free mass [s]: longer than any run, yet finite (0 * inf is no bound)


class Oscillator(Generic[N]):
    """Constants of y'' + 2 a y' + b y: damping a [1/s], stiffness b [1/s^2], load frequency omega [rad/s]."""

    def __init__(self, kit: Kit[N], a: N, b: N, omega: N) -> None:
        self.kit, self.a, self.b, self.omega = kit, a, b, omega
        self.w0 = kit.sqrt(b)
        discriminant = b - a * a
        self.oscillates = discriminant >= 0
        self.wd = kit.sqrt(abs(discriminant))  # damped frequency, or kappa of exp((-a +- kappa) t)
        self.slow = kit.number(0)
        self.fast = kit.number(0)
        if not self.oscillates:
            self.fast = -(a + self.wd)
            self.slow = b / self.fast  # r1 = b / r2: no cancellation far above critical damping
        self.zr = b - omega * omega
        self.zi = 2 * a * omega
        self.zz = self.zr * self.zr + self.zi * self.zi
        near = self.slow * self.slow + omega * omega  # |r1 - i omega|^2 far above critical damping
        self.settling = b if self.oscillates else self.slow * self.slow
        self.beating = self.zz if self.oscillates else near * near
        self.per_b = 1 / b if b > 0 else kit.number(0)
        self.per_wd = 1 / self.wd if self.wd > 0 else kit.number(0)
        self.inverse_r = self.zr / self.zz if self.zz > 0 else kit.number(0)  # 1 / Z, conjugated
        self.inverse_i = self.zi / self.zz if self.zz > 0 else kit.number(0)
        fastest = self.w0 if self.w0 > omega else omega
        pace = fastest if fastest > 0 else 2 * a  # a free mass: only its damping sets a pace
        self.window = 1.5 / pace if pace > 0 else kit.number(UNHURRIED)
        self.rate = a if a > fastest else fastest

    @cached_property
    def steady_series(self) -> list[N]:
        return self._series_coefficients(self.kit.number(0))[0]

    @cached_property
    def loaded_series(self) -> tuple[list[N], list[N]]:
        return self._series_coefficients(self.omega)

    def release_and_impulse(self, t: N) -> tuple[N, N]:
        """C(t) [-] and S(t) [s]."""
        kit = self.kit
        if self.oscillates:
            decay = kit.exp(-(self.a * t))
            angle = self.wd * t
            sine, cosine = kit.sine_cosine(angle)
            impulse = decay * (sine * self.per_wd) if angle != 0 else decay * t
            return decay * cosine + self.a * impulse, impulse
        decay = kit.exp(self.slow * t)
        impulse = decay * (kit.expm1(-(2 * (self.wd * t))) / -(2 * self.wd))
        return decay - self.slow * impulse, impulse

    def constant_response(self, t: N, release: N) -> N:
        """I(t) [s^2], given C(t)."""
        if self.settling * (t * t) >= QUARTER:
            return (1 - release) * self.per_b
        if not self.oscillates and self.wd * t >= 0.5:
            kit = self.kit
            slow = kit.expm1(self.slow * t) / self.slow if self.slow != 0 else t
            return (slow - kit.expm1(self.fast * t) / self.fast) / (2 * self.wd)
        return t * t * horner(self.steady_series, self.rate * t)

    def harmonic_response(self, t: N, release: N, impulse: N, cosine: N, sine: N) -> Responses[N]:
        """Re H(t), Im H(t) [s^2] and their rates [s], given C, S and cos, sin of omega t.

        From H' = S + i omega H, but for a fast load, where that difference would cancel.
        """
        if self.is_quotient(t * t):
            nr = cosine - release
            ni = sine - self.omega * impulse
            vr = self.b * impulse - self.omega * sine
            vi = self.omega * (cosine - (release - 2 * self.a * impulse))
            return (
                nr * self.inverse_r + ni * self.inverse_i,
                ni * self.inverse_r - nr * self.inverse_i,
                vr * self.inverse_r + vi * self.inverse_i,
                vi * self.inverse_r - vr * self.inverse_i,
            )
        hc, hs = self._confluent(t, cosine, sine) if self.wd * t >= 0.5 else self.series_response(t)
        return hc, hs, impulse - self.omega * hs, self.omega * hc

    def is_quotient(self, square: N) -> bool:
        """Whether H is a quotient at the time t whose square is given; it is at all later times too."""
        detuning = self.wd - self.omega
        resonant = self.oscillates and (self.a * self.a + detuning * detuning) * square < RESONANT
        return self.beating * (square * square) >= QUARTER * QUARTER and not resonant

    def series_response(self, t: N) -> tuple[N, N]:
        """Re H, Im H [s^2] by power series, for spreads |r t|, |omega t| below 2."""
        square, angle = t * t, self.rate * t
        real, imag = self.loaded_series
        return square * horner(real, angle), square * horner(imag, angle)

    def _confluent(self, t: N, cosine: N, sine: N) -> tuple[N, N]:
        """H near resonance: (E1 - E2) / (r1 - r2) with E_k = (exp(r_k t) - exp(i omega t)) / (r_k - i omega).

        E1 = t exp((r1 + i omega) t / 2) sinhc((r1 - i omega) t / 2) holds up to the resonance itself
        (secular growth).
        """
        kit = self.kit
        if self.oscillates:
            real1, imag1, real2, imag2 = -self.a, self.wd, -self.a, -self.wd
        else:
            real1, imag1, real2, imag2 = self.slow, kit.number(0), self.fast, kit.number(0)
        p = real1 * t / 2
        q = (imag1 - self.omega) * t / 2
        mean = (imag1 + self.omega) * t / 2
        qr, qi = sinhc(kit, p, q)
        scale = t * kit.exp(p)
        mi, mr = kit.sine_cosine(mean)
        e1r = scale * (mr * qr - mi * qi)
        e1i = scale * (mr * qi + mi * qr)
        decay = kit.exp(real2 * t)
        turned_sine, turned_cosine = kit.sine_cosine(imag2 * t)
        nr = decay * turned_cosine - cosine
        ni = decay * turned_sine - sine
        dr, di = real2, imag2 - self.omega
        dd = dr * dr + di * di
        hr = e1r - (nr * dr + ni * di) / dd
        hi = e1i - (ni * dr - nr * di) / dd
        if self.oscillates:
            return hi / (2 * self.wd), -hr / (2 * self.wd)
        return hr / (2 * self.wd), hi / (2 * self.wd)

    def _series_coefficients(self, omega: N) -> tuple[list[N], list[N]]:
        """Coefficients g_n of H = t^2 sum g_n (rate t)^n, real and imaginary.

        From H'' + 2 a H' + b H = exp(i omega t):
        (n + 2)(n + 1) g_n = (i omega / rate)^n / n! - 2 (a / rate) (n + 1) g_(n-1) - (b / rate^2) g_(n-2).
        """
        kit = self.kit
        rate = self.rate if self.rate > 0 else kit.number(1)
        damping, stiffness, step = 2 * (self.a / rate), (self.b / rate) / rate, omega / rate
        real, imag = [kit.number(0)] * 2, [kit.number(0)] * 2
        lr, li = kit.number(1), kit.number(0)
        for n in range(kit.series_terms):
            divisor = (n + 2) * (n + 1)
            real.append((lr - damping * (n + 1) * real[n + 1] - stiffness * real[n]) / divisor)
            imag.append((li - damping * (n + 1) * imag[n + 1] - stiffness * imag[n]) / divisor)
            lr, li = -(li * step) / (n + 1), lr * step / (n + 1)
        return real[2:], imag[2:]


def sinhc(kit: Kit[N], p: N, q: N) -> tuple[N, N]:
    """Real and imaginary part of sinh(z) / z for z = p + i q."""
    zz = p * p + q * q
    if zz == 0:
        return kit.number(1), kit.number(0)
    sine, cosine = kit.sine_cosine(q)
    nr = kit.sinh(p) * cosine
    ni = kit.cosh(p) * sine
    return (nr * p + ni * q) / zz, (ni * p - nr * q) / zz


def free_harmonic_response(
    kit: Kit[N], omega: N, t: N, cosine: N, sine: N, oscillator: Oscillator[N]
) -> tuple[N, N]:
    """H of a free mass (a = b = 0): int int cos(omega s), int int sin(omega s) [s^2].

    `oscillator` is one with a = b = 0; its series serves short times.
    """
    angle = omega * t
    if angle * angle >= QUARTER:
        return (cosine - 1) * oscillator.inverse_r, (sine - angle) * oscillator.inverse_r
    return oscillator.series_response(t)
