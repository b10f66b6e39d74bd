"""A regime: the constants of one smooth mode of the ideal source."""

from vibsim.flows.responses import Oscillator

JET_ORDER = 9  # derivatives of y taken at the start of a segment: enough for a zero of order 6


class Regime:
    """Constants of one smooth mode: the oscillator of y, its loads, and the spring law of S."""

    def __init__(self, scene, kit, locked, contact, friction):
        zero = kit.number(0)
        inverse = 1 / scene.m1 if locked else 1 / scene.m1 + 1 / scene.m2
        harmonic = scene.source == "harmonic"
        stiffness = scene.k1 + scene.k2 if contact else scene.k1
        offset = scene.k2 * (scene.stop_sign * scene.G) if contact else zero
        omega = scene.omega if harmonic else zero
        self.k, self.offset = stiffness, offset
        self.oscillator = Oscillator(kit, scene.c * inverse / 2, stiffness * inverse, omega)
        self.load = -(offset * inverse)
        if harmonic:
            self.load = self.load + scene.F0 / scene.m1
        self.amplitude = scene.A / scene.m1 if harmonic else zero
        self.forced = [abs(self.amplitude) / 2]  # by n: |R| omega^n / 2
        for _ in range(JET_ORDER):
            self.forced.append(self.forced[-1] * omega)
        self.centre_load = self.centre_amplitude = zero
        if not locked:
            total = scene.m1 + scene.m2
            rub = friction * scene.N if scene.has_friction else zero
            self.load = self.load + rub / scene.m2
            self.centre_load = ((scene.F0 if harmonic else zero) - rub) / total
            self.centre_amplitude = scene.A / total if harmonic else zero
