"""The event functions of the closed-form flow: derivatives, bounds of them ahead, and rounding bounds."""

from vibsim.events.watch import CLEARANCE, GAP, HOLD_PLUS, SLIDE


class EventFunctions:
    """Event functions of a `ClosedForm` flow at the point that it evaluated last.

    Everywhere d holds the derivatives of y = x1 - x2 there, d[0] = y.
    """

    def __init__(self, flow):
        self.flow, self.scene, self.kit = flow, flow.scene, flow.kit
        self.limit = flow.scene.N if flow.scene.has_friction else flow.kit.number(0)

    def derivative(self, function, d, n):
        """n-th time derivative of an event function, n >= 0."""
        scene, mode = self.scene, self.flow.mode
        if function == GAP:
            value = -(scene.stop_sign * d[n])
            value = value - scene.G if n == 0 else value
            return value if mode.contact else -value
        if function == CLEARANCE:
            value = scene.rest_distance - d[0] if n == 0 else -d[n]
            return -value if mode.violated else value
        if function == SLIDE:
            if n == 0:
                return mode.friction * (self.flow.V - self.flow.share2 * self.flow.u)
            force = self._force_derivative(d, n - 1)
            force = force - mode.friction * self.limit if n == 1 else force
            return mode.friction * force / scene.m2
        value = self._force_derivative(d, n)
        value = -value if function == HOLD_PLUS else value
        return self.limit + value if n == 0 else value

    def _force_derivative(self, d, n):
        force = self.flow.regime.k * d[n] + self.scene.c * d[n + 1]
        return force + self.flow.regime.offset if n == 0 else force

    def bound(self, function, d, n, reach):
        """Bound of the absolute n-th derivative of an event function up to `reach` ahead [s], n >= 2."""
        k, c = self.flow.regime.k, self.scene.c
        if function in (GAP, CLEARANCE):
            return self._bound_of_y(d, n, reach)
        if function == SLIDE:
            force = k * self._bound_of_y(d, n - 1, reach) + c * self._bound_of_y(d, n, reach)
            return force / self.scene.m2
        return k * self._bound_of_y(d, n, reach) + c * self._bound_of_y(d, n + 1, reach)

    def _bound_of_y(self, d, n, reach):
        """Bound of |y^(n)| up to `reach` ahead.

        y^(n) obeys the same oscillator: its free part stays below both the energy and the ballistic bound,
        the forced part below |R| omega^n reach^2 / 2 because |S(t)| <= t.
        """
        regime = self.flow.regime
        value, rate, w0 = d[n], d[n + 1], regime.oscillator.w0
        size = abs(value) + abs(rate) * reach
        if w0 > 0:
            energy = abs(value) + abs(rate) / w0
            if energy < size:
                size = energy
        return size + regime.forced[n] * (reach * reach)

    def noise(self, function):
        """Rounding bound of an event function."""
        scene, flow = self.scene, self.flow
        regime = flow.regime
        unit = self.kit.eps * (16 + regime.oscillator.w0 * flow.tau)
        if function == GAP:
            return unit * (flow.scale_y + abs(scene.G))
        if function == CLEARANCE:
            return unit * (flow.scale_y + abs(scene.rest_distance))
        if function == SLIDE:
            return unit * (flow.scale_V + flow.share2 * flow.scale_u)
        return unit * (regime.k * flow.scale_y + scene.c * flow.scale_u + abs(regime.offset) + self.limit)
