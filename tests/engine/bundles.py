"""Disturbances of scenes made of parts: runs with exponents, and difference quotients in 40 digits."""

from fractions import Fraction
from math import isnan

from tests.engine.many_digits import exact_parts
from vibsim.engine.errors import start_of
from vibsim.engine.modes.status import RESTING
from vibsim.engine.modes.ties import Groups
from vibsim.engine.number_forms import WordsForm
from vibsim.engine.tangent.carried import state_of
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.tangent.tangent_space import components, dimension, length, references
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.precision import number_kit

PER_PIECE = 400 * 2.0**-53  # of the volume: cut-off 1.65**20 / 20! = 9e-15, rounding of the vectors
SHIFT = Fraction(
    1, 10**18
)  # the quotient is then wrong by 1e-18 times the second derivative, and by 1e-40 / 1e-18
CLOSE = 1e-12  # numbers given as doubles, omega and omega / (2 pi) among them, agree to 1e-16


def totals(scene, count=None, begin=0.0):
    """Totals of the run of `scene` with `count` exponents (None: all) from the time `begin` [s]."""
    count = dimension(scene) if count is None else count
    trajectory = open_trajectory(scene, tangent=count, tangent_from=begin)
    for _ in trajectory.blocks():
        pass
    return trajectory.totals


def volume_bound(found, span):
    """Of the residual of a run of `span` [s]: free masses shear the vectors by the length of a piece."""
    return PER_PIECE * found["tangent_pieces"] * max(1.0, span / found["tangent_pieces"]) ** 2


def start_components(scene):
    """Components of the start of a scene: x and v of all bodies, angle and speed of a motor."""
    rotor = (scene.motor.phi, scene.motor.phidot) if scene.motor is not None else ()
    return [*(body.x for body in scene.bodies), *(body.v for body in scene.bodies), *rotor]


class InDigits:
    """Motions of a scene of doubles in many digits, with disturbances of its start."""

    def __init__(self, scene, digits=40):
        self.kit = kit = number_kit(digits)
        kit.activate()
        exact = exact_parts(scene)(kit.number, kit.pi)
        self.begin, self.end = start_of(exact, kit), exact.t_end
        self.start = start_components(exact)
        self.scene, self.carrier = exact, Carrier(exact, WordsForm(kit))
        self.mode = self._mode(self.begin)

    def _mode(self, begin):
        status, _ = self.carrier._tuned().automaton.initial(begin)
        return status

    def possible(self):
        """A basis of the disturbances that the mode of the start allows."""
        return possible(self.scene, self.kit, self.carrier._tuned().maker.rows(self.mode))

    def carry(self, vectors=()):
        """The motion from the start, with `vectors`."""
        return self.carrier.carried(self.start, self.end, vectors)

    def quotient(self, shift, base, by=SHIFT):
        """Difference quotient of the ends of `base` and of the motion whose start is shifted by `by` or
        -`by` times a disturbance: by the one that begins in the same mode, since a start exactly where a
        stop or a friction changes has a derivative to that side alone. None where neither does, or where
        the motion takes another course.
        """
        for small in (self.kit.number(by), -self.kit.number(by)):
            start = [value + small * ahead for value, ahead in zip(self.start, shift, strict=True)]
            if self._mode(state_of(self.scene, self.kit, self.kit.number(0), start)) == self.mode:
                moved = self.carrier.carried(start, self.end, ())
                if moved.events == base.events:
                    return [
                        (there - here) / small for there, here in zip(moved.state, base.state, strict=True)
                    ]
        return None


def assert_derivative(scene, doubles=None):
    """What becomes of disturbances in 40 digits are difference quotients there: all but those whose motion
    takes another course. Returns their number and the kinds of the events.

    A body that is let go where it just touches a stop leaves as t^3 (its force grows from zero): shifted, it
    meets the stop by the cube root of the shift later, and by as much the quotient is off. So one that is not
    close has to come nearer as the shift falls: to a tenth with a thousandth of it. A wrong derivative stays
    as far off as it is.

    doubles : how near to the quotients those in doubles have to come [share of the largest, or of 1]
    """
    digits = InDigits(scene)
    vectors, columns = digits.possible(), 0
    base = digits.carry(vectors=vectors)
    kinds = {kind for kind, _ in base.events}
    if not isnan(base.undefined_at):
        return 0, kinds
    for vector, ours in zip(vectors, base.vectors, strict=True):
        theirs = digits.quotient(vector, base)
        if theirs is None:
            continue
        largest = max(max(abs(float(value)) for value in theirs), 1e-3)
        off = distance(ours, theirs)
        if off >= CLOSE * largest:
            assert distance(ours, digits.quotient(vector, base, SHIFT / 1000)) < off / 8
        if doubles is not None:
            given = [[float(value) for value in vector]]
            (found,) = Carrier(scene).carry(start_components(scene), scene.t_end, given).vectors
            apart = max(abs(one - float(other)) for one, other in zip(found, theirs, strict=True))
            assert apart < doubles * max(largest, 1.0)
        columns += 1
    return columns, kinds


def distance(ours, theirs):
    """The largest difference of two vectors."""
    return max(abs(float(one - other)) for one, other in zip(ours, theirs, strict=True))


def possible(scene, kit, rows):
    """Disturbances that span those of a mode: what rests on each other has one displacement, what sticks to
    each other one velocity.
    """
    n, reference, inside = len(scene.bodies), references(scene), []

    def vector(ones):
        return [kit.number(1 if k in ones else 0) for k in range(length(scene))]

    resting = [stop for stop, now in zip(scene.stops, rows.status.stops, strict=True) if now == RESTING]
    seats = Groups(n, [(0, scene.column(stop.P), scene.column(stop.Q)) for stop in resting])
    for leader, members in sorted(seats.members.items()):
        bodies = {c for c in members if c < n}
        if leader < n and not any(reference[c] == c for c in bodies):
            inside.append(vector(bodies))
    inside += [vector({k}) for k in components(scene) if k >= 2 * n]
    for leader, members in sorted(rows.groups.members.items()):
        if leader < n:
            inside.append(vector({n + c for c in members if c < n}))
    return inside
