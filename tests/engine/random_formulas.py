"""Random scenes with formulas: bodies, rotors and further states with every function, switch and power."""

import math
from fractions import Fraction
from itertools import pairwise
from random import Random

from vibsim.physics.formulas import (
    ONE,
    PI,
    TIME,
    ZERO,
    absolute,
    add,
    call,
    choose,
    div,
    largest,
    mul,
    neg,
    num,
    power,
    smallest,
    sub,
)
from vibsim.physics.parts import (
    AT_FORCE,
    AT_GAP,
    BASE,
    COMPRESSION,
    EXTENSION,
    GROUND,
    ROTOR,
    STATE,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
    Rotor,
    Scene,
    Stop,
)

LENGTH, RATE = 0.01, 2 * math.pi  # scales of displacements [m] and rates [rad/s]
SIZE = RATE**2 * LENGTH  # of forces [N]
BOUNDED = ("sin", "cos", "tanh", "atan")  # functions of any argument with small values
SMOOTH = ("exp", "sinh", "cosh")  # functions that grow
EXPONENTS = ("1/2", "3/2", "5/2", "-1/2", "-3/2", "1/3", "7/5", "-4/3")


def decimal(random, low, high):
    """A number with few digits."""
    return num(Fraction(round(random.uniform(low, high), 3)).limit_denominator(1000))


def scaled(size):
    """A size as a number of a formula."""
    return num(Fraction(size).limit_denominator(10**6))


class Formulas:
    """Draws formulas that read `inputs`, pure numbers of about 1.

    jumps : whether they may jump
    """

    def __init__(self, random, inputs, jumps):
        self.random, self.inputs, self.jumps = random, inputs, jumps

    def one(self, depth=3):
        """A formula of about 1, at most `depth` functions deep."""
        random = self.random
        if depth == 0 or random.random() < 0.15:
            return random.choice(self.inputs) if random.random() < 0.85 else decimal(random, -2, 2)
        kinds = [
            self.sum, self.product, self.quotient, self.function, self.root, self.arc, self.kink,
            self.table,
        ]  # fmt: skip
        return random.choice(kinds + [self.jump] * self.jumps)(depth - 1)

    def sum(self, depth):
        a, b = self.one(depth), self.one(depth)
        return add(mul(decimal(self.random, -2, 2), a), b) if self.random.random() < 0.5 else sub(a, b)

    def product(self, depth):
        a = self.one(depth)
        if self.random.random() < 0.3:
            return mul(decimal(self.random, -0.5, 0.5), power(a, num(self.random.choice((2, 3)))))
        return mul(a, self.one(depth))

    def quotient(self, depth):
        b = self.one(depth)
        return div(self.one(depth), add(decimal(self.random, 0.5, 2), mul(b, b)))

    def function(self, depth):
        if self.random.random() < 0.7:
            name = self.random.choice(BOUNDED)
            return call(name, mul(decimal(self.random, -3, 3), self.one(depth)))
        name = self.random.choice(SMOOTH)
        return call(name, mul(decimal(self.random, -0.5, 0.5), self.small(depth)))

    def small(self, depth):
        """A formula between -3 and 3."""
        return mul(num(2), call(self.random.choice(("atan", "tanh", "sin")), self.one(depth)))

    def root(self, depth):
        a = self.one(depth)
        inside = add(decimal(self.random, 0.2, 2), mul(a, a))
        if self.random.random() < 0.3:
            return call("log", inside)
        exponent = num(self.random.choice(EXPONENTS))
        return power(inside, exponent) if self.random.random() < 0.8 else power(inside, self.small(depth))

    def arc(self, depth):
        inside = mul(num("9/10"), call(self.random.choice(("sin", "tanh")), self.one(depth)))
        name = self.random.choice(("asin", "acos", "tan"))
        return call(name, inside)

    def kink(self, depth):
        a, b = self.one(depth), self.one(depth)
        which = self.random.randrange(4)
        if which == 0:
            return absolute(a, "abs(a)")
        if which == 1:
            return largest(a, b, "max(a, b)")
        return smallest(a, b, "min(a, b)") if which == 2 else mul(a, absolute(a, "abs(a)"))

    def table(self, depth):
        """A polyline through four points."""
        knots = tuple(Fraction(k, 10) for k in sorted(self.random.sample(range(-25, 25), 4)))
        values = [Fraction(self.random.randint(-20, 20), 10) for _ in knots]
        pieces = tuple(
            (low, (high - low) / (end - start))
            for (low, high), (start, end) in zip(pairwise(values), pairwise(knots), strict=True)
        )
        return ("table", self.one(depth), knots, pieces, "table(a)")

    def jump(self, depth):
        g = self.one(depth)
        if self.random.random() < 0.25:
            return ("mod", add(num(7), g), decimal(self.random, 0.5, 2), "mod(a, b)")
        a, b = (num(1), num(-1)) if self.random.random() < 0.3 else (self.one(depth), self.one(depth))
        return choose(g, a, b, "where(g > 0, a, b)")


class RandomScene:
    """Draws a scene; the same for the same seed."""

    def __init__(self, seed):
        self.random = Random(seed)
        random = self.random
        self.jumps = random.random() < 0.25
        self.lines = random.randint(1, 3)
        self.rotors = random.choice((0, 0, 0, 1, 2))
        self.states = random.choice((0, 0, 0, 1, 2))
        self.motor = self.rotors == 0 and random.random() < 0.15
        self.base = random.choice(("none", "none", "none", "sine", "formula"))

    def ends(self):
        P = self.random.randrange(self.lines)
        others = [k for k in range(self.lines) if k != P] + [GROUND] + [BASE] * (self.base != "none")
        Q = self.random.choice(others)
        return (P, Q) if self.random.random() < 0.5 else (Q, P)

    def formula(self, *own):
        """A formula of about 1 of own inputs, and now and then of others."""
        inputs = [*own] * 3
        inputs.append(mul(num(6), TIME))
        for _ in range(2):
            k = self.random.randrange(self.lines)
            inputs.append(mul(num(100), ("x", k)) if self.random.random() < 0.5 else mul(num(15), ("v", k)))
        for k in range(self.lines, self.lines + self.rotors):
            inputs += [("sin", ("x", k)), mul(num("1/6"), ("v", k))]
        for k in range(self.lines + self.rotors, self.lines + self.rotors + self.states):
            inputs.append(("v", k))
        if self.motor:
            inputs += [("cos", ("phi",)), mul(num("1/6"), ("w",))]
        return Formulas(self.random, inputs, self.jumps).one(self.random.randint(1, 3))

    def between(self, P, Q):
        """Difference and its rate between two ends, in units of about 1."""
        d, v = sub(("x", P), ("x", Q)), sub(("v", P), ("v", Q))
        return mul(num(100), d), mul(num(15), v)

    def size(self):
        return scaled(SIZE * 10 ** self.random.uniform(-1, 0.3))

    def link(self, i):
        P, Q = self.ends()
        if self.random.random() < 0.3:
            return Link(f"l{i}", P, Q, RATE**2 * self.random.uniform(0.5, 2), self.random.choice((0.0, 0.5)))
        d, v = self.between(P, Q)
        law = add(mul(self.size(), d), mul(self.size(), self.formula(d, v)))
        return Link(f"l{i}", P, Q, 0.0, 0.0, law)

    def stop(self, i):
        P, Q = self.ends()
        sense = self.random.choice((EXTENSION, COMPRESSION))
        gap = self.random.choice((0.0, 0.003, 0.01, -0.002))
        release = self.random.choice((AT_GAP, AT_GAP, AT_FORCE))
        if self.random.random() < 0.2:
            return RigidStop(f"s{i}", P, Q, abs(gap) + 0.02, sense, self.random.choice((0.0, 0.5, 0.8)))
        if self.random.random() < 0.2:
            return Stop(f"s{i}", P, Q, gap, sense, 10 * RATE**2, self.random.choice((0.0, 3.0)), release)
        depth = sub(mul(num(sense), sub(("x", Q), ("x", P))), num(Fraction(gap)))
        rate = mul(num(sense), sub(("v", Q), ("v", P)))
        p, pv = mul(num(100), depth), mul(num(15), rate)
        if release == AT_GAP and self.random.random() < 0.5:
            law = power(p, num(self.random.choice(("3/2", "5/2", "7/5"))))
        else:
            law = add(mul(num(3), p), mul(num("1/5"), self.formula(p, pv)))
        if self.random.random() < 0.4:
            law = mul(law, add(ONE, mul(num("1/5"), pv)))
        law = mul(mul(num(5), self.size()), law)
        if release == AT_FORCE:
            law = largest(ZERO, law, "max(0, F)") if self.random.random() < 0.3 else law
        return Stop(f"s{i}", P, Q, gap, sense, 0.0, 0.0, release, False, law)

    def friction(self, i):
        P, Q = self.ends()
        belt = self.random.choice((0.0, 0.0, 0.02))
        slip = 0.2 * SIZE
        if self.random.random() < 0.3:
            return Friction(f"f{i}", P, Q, slip, slip, belt, self.random.choice((None, 1.3 * slip)))
        load = add(num(2), mul(num("1/5"), self.formula(mul(num(6), TIME))))
        load = largest(load, ZERO, "max(N, 0)")
        speed = sub(sub(("v", P), ("v", Q)), num(Fraction(belt)))
        static = self.random.choice((ONE, num("13/10")))
        slips, holds = [], []
        for sense in (1, -1):
            s = mul(num(15 * sense), speed)
            mu = add(num("1/10"), mul(num("1/20"), call("exp", neg(mul(s, s)))))
            slips.append(mul(mul(scaled(SIZE), load), mu))
            holds.append(mul(mul(scaled(SIZE), load), mul(static, num("3/20"))))
        return Friction(
            f"f{i}", P, Q, 0.0, 0.0, belt, slips=tuple(slips), holds=tuple(holds), rises=(static != ONE,) * 2
        )

    def force(self, i):
        on = self.random.randrange(self.lines)
        omega = 7.5
        sine = Harmonic(SIZE, omega, omega / (2 * math.pi), 0.0, 0.3)
        terms = (sine,) if self.random.random() < 0.4 else ()
        x, v = mul(num(100), ("x", on)), mul(num(15), ("v", on))
        law = mul(self.size(), self.formula(x, v)) if self.random.random() < 0.8 else None
        return Force(f"F{i}", on, self.random.choice((0.0, 0.3)), terms, law)

    def bodies(self):
        random, bodies = self.random, []
        for i in range(self.lines):
            x, v = random.choice((0.0, LENGTH, -0.7 * LENGTH)), random.choice((0.0, LENGTH * RATE, -0.02))
            bodies.append(Body(f"b{i}", random.choice((1.0, 0.5, 2.0)), x, v))
        for i in range(self.rotors):
            bodies.append(Body(f"r{i}", 2e-4, random.uniform(-3, 9), random.choice((0.0, 20.0)), ROTOR))
        for i in range(self.states):
            bodies.append(Body(f"z{i}", 1.0, 0.0, random.choice((0.0, 1.0)), STATE))
        return tuple(bodies)

    def drives(self):
        """Torques of rotors and rates of states."""
        first, drives = self.lines, []
        for k in range(first, first + self.rotors):
            if self.random.random() < 0.8:
                speed = mul(num("1/6"), ("v", k))
                law = mul(num("1/500"), sub(self.formula(speed, ("sin", ("x", k))), speed))
                drives.append(Force(f"r{k}", k, 0.0, (), law))
        first += self.rotors
        for k in range(first, first + self.states):
            law = mul(num(5), sub(self.formula(("v", k)), ("v", k)))
            drives.append(Force(f"z{k}", k, 0.0, (), law))
        return drives

    def base_parts(self):
        if self.base == "sine":
            return {"base": (Harmonic(LENGTH, 5.0, 5.0 / (2 * math.pi), 0.0, 0.5),)}
        if self.base == "formula":
            rise = smallest(mul(num(3), TIME), ONE, "min(3 t, 1)")
            sine = call("sin", mul(mul(num(2), PI), TIME))
            return {"base_formula": mul(num("1/100"), mul(rise, sine))}
        return {}

    def scene(self):
        random = self.random
        links = tuple(self.link(i) for i in range(random.randint(1, self.lines)))
        stops = tuple(self.stop(i) for i in range(random.choice((0, 0, 1, 2))))
        frictions = tuple(self.friction(i) for i in range(random.choice((0, 0, 1, 2))))
        forces = tuple(self.force(i) for i in range(random.randint(0, 2)))
        rotors = tuple(
            Rotor(self.lines + i, random.randrange(self.lines), random.choice((0.0, 3e-3)))
            for i in range(self.rotors)
        )
        motor = Motor(0, 0.1, 0.02, 1e-4, 1e-3, 1.5 * RATE, 0.5, random.choice((0.0, 6.0)))
        clearances = (Clearance("k", *self.ends(), 0.008),) if random.random() < 0.2 else ()
        return Scene(
            self.bodies(),
            links,
            stops,
            frictions,
            (*forces, *self.drives()),
            motor=motor if self.motor else None,
            clearances=clearances,
            rotors=rotors,
            t_end=random.choice((0.5, 1.0, 2.0)),
            every_num=1,
            every_den=40,
            **self.base_parts(),
        )


def formula_scene(seed):
    """The random scene of a seed."""
    return RandomScene(seed).scene()
