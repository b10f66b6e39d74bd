"""How small disturbances move inside a mode of the closed-form flow.

A mode of the ideal source is linear with a load that no disturbance changes, so a disturbance obeys the
homogeneous equations: its relative part the damped oscillator without load, its centre of mass x'' = 0.
"""

E_FOLDS = 8  # of decay in one piece: neighbouring directions then part by 3 of the 16 digits at most


class ClosedFormTangent:
    """Moves disturbances along the stretch that `flow` has just done."""

    def __init__(self, scene, kit, flow):
        self.scene, self.kit, self.flow = scene, kit, flow

    def piece_end(self, t, end, mark):
        """End [s] of the piece from t that is moved at once: at most `end`, not beyond `mark` where that is
        ahead, and short enough that no direction is lost below round-off.
        """
        osc = self.flow.regime.oscillator
        decay = osc.a if osc.oscillates else osc.a + osc.wd
        ahead = t + E_FOLDS / decay if decay > 0 else end
        ahead = mark if t < mark < ahead else ahead
        return ahead if t < ahead < end else end

    def prepare(self, t, end):
        """Responses of the oscillator over the piece from t to `end` [s]."""
        osc = self.flow.regime.oscillator
        self.release, self.impulse = osc.release_and_impulse(end - t)
        self.rate = self.release - 2 * osc.a * self.impulse
        self.stiff = osc.b * self.impulse

    def moved(self, vector):
        """The disturbance that `vector` becomes over the piece prepared last; while block 2 rests its dv2
        stays, without effect on the others.
        """
        flow = self.flow
        dy, dv1, dv2, dphi, dw = vector
        du = dv1 if flow.locked else dv1 - dv2
        y = dy * self.release + du * self.impulse
        u = du * self.rate - dy * self.stiff
        if flow.locked:
            return [y, u, dv2, dphi, dw]
        V = flow.share2 * dv1 + flow.share1 * dv2
        return [y, V + flow.share1 * u, V - flow.share2 * u, dphi, dw]

    def log_volume(self, t, end):
        """Logarithm of the growth of a volume of (y, v1, v2) from t to `end` [s]: -2 a (end - t)."""
        return -(2 * self.flow.regime.oscillator.a * (end - t))
