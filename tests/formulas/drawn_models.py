"""Random scenes with formulas: as the text of a case, and as a model for the second solver.

Every number beside a formula has a unit, so the text also goes through the units of the language. Scales are
those of a body of some 1 kg on a spring of some 10 rad/s that moves by centimetres.
"""

from __future__ import annotations

import random

from tests.formulas.second_expressions import call, numbers_of, par, product, text, total
from tests.formulas.second_model import Base, Force, Friction, Link, Model, Rotor, Stop

T = ("name", "t")
D, V, DEPTH, PV, S = (("name", word) for word in ("d", "v", "p", "pv", "s"))
ONE = ("num", 1)


def spread(rng, low, high):
    """A number of three digits, its logarithm uniform."""
    return float(f"{low * (high / low) ** rng.random():.3g}")


def even(rng, low, high):
    """A number of three digits."""
    return float(f"{rng.uniform(low, high):.3g}")


class Drawn:
    """A scene drawn by a seed: `model`, and `case`, its text."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.length = 0.02  # m
        self.model = Model({})
        self._bodies()
        self._links()
        self._stops()
        self._frictions()
        self._rotors()
        self._states()
        self._forces()
        self._base()
        self._set_in_motion()
        self.model.t_end = self.rng.choice([1.6, 2.4, 3.2])
        self.case = self._text(seed)

    # Parts.

    def _bodies(self) -> None:
        rng = self.rng
        for name in ("a", "b")[: rng.choice([1, 1, 2])]:
            x = 0.0 if rng.random() < 0.3 else even(rng, -self.length, self.length)
            v = 0.0 if rng.random() < 0.4 else even(rng, -0.3, 0.3)
            self.model.bodies[name] = (spread(rng, 0.5, 2.0), x, v)

    def _links(self) -> None:
        rng, names = self.rng, list(self.model.bodies)
        self.uses_base = rng.random() < 0.25
        ends = [("a", "base" if self.uses_base else "ground")]
        if "b" in names:
            ends.append(("b", "a"))
        for k, (P, Q) in enumerate(ends):
            force = self._spring()
            self.model.links.append(Link(f"link{k}", P, Q, force))

    def _spring(self):
        rng = self.rng
        k = par("k", spread(rng, 40, 300), "N/m")
        d0 = par("d0", spread(rng, 5, 40), "mm")
        c = par("c", spread(rng, 0.05, 2), "N s/m")
        ratio = ("/", D, d0)
        restoring = [
            lambda: product(k, D),
            lambda: total(product(k, D), product(par("k3", spread(rng, 2e4, 5e5), "N/m^3"), ("**", D, 3))),
            lambda: product(k, d0, call("tanh", ratio)),
            lambda: product(k, d0, call("atan", ratio)),
            lambda: product(k, d0, call("sinh", product(("num", 0.3), ratio))),
            lambda: ("/", product(k, D), call("sqrt", total(ONE, ("**", ratio, 2)))),
            lambda: product(k, D, total(ONE, call("exp", ("-", ("num", 0), ("**", ratio, 2))))),
            lambda: product(k, D, total(ONE, call("log", total(ONE, ("**", ratio, 2))))),
            lambda: product(k, d0, call("asin", product(("num", 0.6), call("tanh", ratio)))),
            lambda: product(k, total(("max", ("-", D, d0), ("num", 0)), ("min", total(D, d0), ("num", 0)))),
            lambda: ("/", product(k, D, ("abs", D)), d0),
            lambda: (
                "where",
                D,
                "<",
                ("num", 0),
                product(k, D),
                product(par("kp", spread(rng, 100, 900), "N/m"), D),
            ),
            lambda: product(
                k,
                D,
                total(
                    ONE, product(("num", 0.4), call("cos", product(par("w0", even(rng, 0.5, 4), "Hz"), T)))
                ),
            ),
            lambda: product(k, d0, ("-", call("cosh", ratio), ONE), ("/", D, total(d0, ("abs", D)))),
            lambda: product(
                par("F", 1.0, "N"),
                ("table", ratio, ((-2.0, -3.0), (-0.5, -1.0), (0.4, 0.9), (3.0, 6.0)), ("", ""), "linear"),
            ),
        ]
        damping = [
            lambda: product(c, V),
            lambda: total(product(c, V), product(par("q", spread(rng, 0.5, 6), "N s^2/m^2"), V, ("abs", V))),
            lambda: product(c, V, total(("num", 0.2), ("**", ratio, 2))),
            lambda: product(
                par("cf", spread(rng, 0.1, 1), "N"), call("tanh", ("/", V, par("v0", 0.1, "m/s")))
            ),
        ]
        return total(rng.choice(restoring)(), rng.choice(damping)())

    def _stops(self) -> None:
        rng, contact = self.rng, self.rng.random()
        if contact < 0.35:
            return
        ends = ("b", "a") if "b" in self.model.bodies and rng.random() < 0.5 else ("a", "ground")
        sense = rng.choice([1, -1])
        if contact < 0.5:
            gap = self._gap(ends, sense)
            self.model.stops.append(Stop("stop", *ends, gap, sense, e=even(rng, 0.5, 0.95)))
            return
        self._stop("stop", ends, sense)
        if rng.random() < 0.3:
            self._stop("other", ends, -sense)

    def _gap(self, ends: tuple[str, str], sense: int) -> float:
        """Open at the start by 2 mm or more."""
        P, Q = ends
        start = self.model.bodies[P][1] - (self.model.bodies[Q][1] if Q != "ground" else 0.0)
        return float(f"{max(even(self.rng, 2e-3, 1.5 * self.length), sense * start + 2e-3):.3g}")

    def _stop(self, name: str, ends: tuple[str, str], sense: int) -> None:
        rng, gap = self.rng, self._gap(ends, sense)
        K, lam = par("K", spread(rng, 3e3, 3e4), "N/m"), par("lam", spread(rng, 0.05, 1), "s/m")
        KH, l0 = par("KH", spread(rng, 3e4, 5e5), "N/m^1.5"), par("l0", 10.0, "mm")
        laws = [
            total(product(K, DEPTH), product(par("C", spread(rng, 1, 20), "N s/m"), PV)),
            product(KH, ("**", DEPTH, 1.5)),
            product(KH, ("**", DEPTH, 1.5), total(ONE, product(lam, PV))),
            product(K, l0, ("**", ("/", DEPTH, l0), 2), total(ONE, product(lam, PV))),
            product(K, l0, ("**", ("/", DEPTH, l0), 2.5)),
            total(product(K, DEPTH), product(par("K3", spread(rng, 1e7, 1e8), "N/m^3"), ("**", DEPTH, 3))),
        ]
        law = rng.choice(laws)
        release = "force" if law is laws[0] and rng.random() < 0.5 else "gap"
        self.model.stops.append(Stop(name, *ends, gap, sense, law, release))

    def _frictions(self) -> None:
        rng, bodies = self.rng, list(self.model.bodies)
        if rng.random() < 0.5 or any(stop.e is not None for stop in self.model.stops):
            return
        self._friction("rub", rng.choice(bodies), "ground", rng.choice([0.0, 0.0, even(rng, -0.15, 0.15)]))
        if len(bodies) == 2 and rng.random() < 0.4:
            self._friction("between", "b", "a", 0.0)

    def _friction(self, name: str, P: str, Q: str, belt: float) -> None:
        rng = self.rng
        n0, w = par("n0", spread(rng, 1, 12), "N"), par("wn", even(rng, 0.3, 3), "Hz")
        loads = [
            n0,
            total(n0, product(par("n1", spread(rng, 1, 12), "N"), call("sin", product(w, T)))),
            ("-", n0, product(par("kn", spread(rng, 50, 600), "N/m"), ("name", f"x_{P}"))),
            ("where", T, "<", par("tn", even(rng, 0.3, 1.5), "s"), n0, par("n2", spread(rng, 1, 12), "N")),
            product(n0, call("exp", ("-", ("num", 0), ("/", T, par("tau", even(rng, 0.5, 2), "s"))))),
        ]
        mu_s, mu_d = par("mu_s", even(rng, 0.15, 0.3)), par("mu_d", even(rng, 0.05, 0.15))
        ratio = ("/", S, par("vs", even(rng, 0.03, 0.2), "m/s"))
        falling = [
            call("exp", ("-", ("num", 0), ("**", ratio, 2))),
            call("exp", ("-", ("num", 0), ratio)),
            ("/", ONE, total(ONE, ratio)),
        ]
        laws = [mu_d, total(mu_d, product(("-", mu_s, mu_d), rng.choice(falling)))]
        static = rng.choice([1.0, 1.0, 1.2])
        self.model.frictions.append(Friction(name, P, Q, rng.choice(loads), rng.choice(laws), static, belt))

    def _rotors(self) -> None:
        rng = self.rng
        if rng.random() < 0.65:
            return
        for name in ("left", "right")[: rng.choice([1, 1, 2])]:
            m, e, J = spread(rng, 0.02, 0.2), spread(rng, 10, 60), spread(rng, 1e-5, 1e-3)
            T0, w0 = par("T0", spread(rng, 0.005, 0.1), "N m"), par("w0", even(rng, 1, 5), "Hz")
            w = ("name", "w")
            line = product(T0, ("-", ONE, ("/", w, w0)))
            weight = product(
                ("name", "m"), par("g", 9.81, "m/s^2"), ("name", "e"), call("cos", ("name", "phi"))
            )
            torque = rng.choice([line, ("-", line, weight), ("-", ("num", 0), weight), None])
            start = even(rng, -3, 3), even(rng, -10, 20)
            self.model.rotors.append(
                Rotor(name, rng.choice(list(self.model.bodies)), m, e * 1e-3, J, torque, *start)
            )

    def _states(self) -> None:
        rng = self.rng
        if rng.random() < 0.6:
            return
        body = rng.choice(list(self.model.bodies))
        z, v, x = ("name", "z"), ("name", f"v_{body}"), ("name", f"x_{body}")
        u = par("u", spread(rng, 5, 20), "mm")
        yielding = (
            "-",
            v,
            ("/", total(product(par("be", 0.6), ("abs", v), z), product(par("ga", 0.4), v, ("abs", z))), u),
        )
        lag = ("/", ("-", x, z), par("tau", spread(rng, 0.02, 0.5), "s"))
        square = (
            "-",
            product(par("r", spread(rng, 1, 5), "1/s"), x),
            ("/", product(("abs", z), z, par("q", 1.0, "1/s")), u),
        )
        self.model.states["z"] = (rng.choice([yielding, lag, square]), 0.0)
        kz = par("kz", spread(rng, 20, 100), "N/m")
        self.model.forces.append(Force("hysteresis", body, ("-", ("num", 0), product(kz, z))))

    def _forces(self) -> None:
        rng = self.rng
        if rng.random() < 0.2:
            return
        A, w = par("A", spread(rng, 0.3, 5), "N"), par("w0", even(rng, 0.5, 4), "Hz")
        T1, T2 = par("T1", even(rng, 0.1, 0.7), "s"), par("T2", even(rng, 0.8, 1.5), "s")
        wave = call("sin", product(w, T))
        zero = ("num", 0)
        pairs = ((0.1, 0.0), (0.35, even(rng, -4, 4)), (0.8, even(rng, -4, 4)), (1.3, 0.0))
        laws = [
            product(A, wave),
            product(
                A,
                call("sin", total(product(w, T), product(par("r", even(rng, 1, 10), "1/s^2"), ("**", T, 2)))),
            ),
            ("where", T, "<", T1, product(A, call("sin", ("/", product(("name", "pi"), T), T1))), zero),
            product(A, ("step", ("-", T, T1))),
            product(A, ("-", ("step", ("-", T, T1)), ("step", ("-", T, T2)))),
            product(A, ("min", ("/", T, T1), ONE), wave),
            product(A, call("exp", ("-", zero, ("/", T, T1))), call("cos", product(w, T))),
            product(A, ("-", ("/", ("mod", T, T1), T1), ("num", 0.5))),
            product(A, ("sign", wave)),
            ("table", T, pairs, ("s", "N"), "linear"),
            ("table", T, pairs, ("s", "N"), "cubic"),
            ("/", product(A, wave), total(ONE, ("**", ("/", T, T1), 2))),
            product(A, ("max", wave, ("num", 0.2))),
        ]
        self.model.forces.append(Force("push", rng.choice(list(self.model.bodies)), rng.choice(laws)))

    def _base(self) -> None:
        if not self.uses_base:
            return
        rng = self.rng
        a, w = par("a0", spread(rng, 1, 8), "mm"), par("wb", even(rng, 0.5, 3), "Hz")
        phase = product(w, T)
        sine, cosine = call("sin", phase), call("cos", phase)
        self.model.base = Base(
            product(a, sine), product(a, w, cosine), ("-", ("num", 0), product(a, w, w, sine))
        )

    def _set_in_motion(self) -> None:
        """What nothing moves may rest for ever, where a load that vanishes makes stick a matter of words."""
        bodies, driven = self.model.bodies, self.model.base or self.model.rotors or self.model.forces
        if not driven and all(x == v == 0 for _, x, v in bodies.values()):
            mass, x, _ = bodies["a"]
            bodies["a"] = (mass, x, 0.1)

    # The text of the case.

    def _text(self, seed: int) -> str:
        model = self.model
        lines = [f"name: drawn-{seed}"]
        lines.append("bodies: {" + ", ".join(f"{n}: {m!r} kg" for n, (m, _, _) in model.bodies.items()) + "}")
        lines += self._section(
            "links", model.links, lambda o: self._with(f"between: [{o.P}, {o.Q}]", force=o.force)
        )
        lines += self._section("stops", model.stops, self._stop_text)
        lines += self._section("friction", model.frictions, self._friction_text)
        lines += self._section("forces", model.forces, lambda o: self._with(f"on: {o.on}", force=o.force))
        lines += self._section("rotors", model.rotors, self._rotor_text)
        for name, (rate, _) in model.states.items():
            lines.append(f"states: {{{name}: {{{self._with('start: 0 m', rate=rate)}}}}}")
        if model.base:
            lines.append(f"base: {{{self._with('', x=model.base.x)}}}")
        starts = [f"{n}: {{x: {x!r} m, v: {v!r} m/s}}" for n, (_, x, v) in model.bodies.items()]
        starts += [f"{o.name}: {{phi: {o.phi!r} rad, w: {o.w!r} rad/s}}" for o in model.rotors]
        lines.append("initial: {" + ", ".join(starts) + "}")
        lines.append(f"run: {{t_end: {model.t_end} s, every: {model.t_end / 8!r} s}}")
        return "\n".join(lines) + "\n"

    @staticmethod
    def _with(first: str, **formulas) -> str:
        """Keys of a part: its formulas, and the numbers beside them."""
        words = [first] if first else []
        words += [f'{key}: "{text(e)}"' for key, e in formulas.items()]
        words += [f"{name}: {value}" for name, value in numbers_of(*formulas.values()).items()]
        return ", ".join(words)

    @staticmethod
    def _section(name, parts, of_part):
        if not parts:
            return []
        return [f"{name}:", *(f"  {o.name}: {{{of_part(o)}}}" for o in parts)]

    def _stop_text(self, o: Stop) -> str:
        acts = "compression" if o.sense > 0 else "extension"
        head = f"between: [{o.P}, {o.Q}], gap: {o.gap!r} m, acts: {acts}"
        if o.force is None:
            return f"{head}, law: rigid, e: {o.e!r}"
        return self._with(f"{head}, release: {o.release}", force=o.force)

    def _friction_text(self, o: Friction) -> str:
        head = f"between: [{o.P}, {o.Q}], static: {o.static!r}, belt: {o.belt!r} m/s"
        plain = {key: e for key, e in (("N", o.load), ("mu", o.mu)) if e[0] == "par"}
        formulas = {key: e for key, e in (("N", o.load), ("mu", o.mu)) if key not in plain}
        words = [f"{key}: {e[2]!r} {e[3]}".strip() for key, e in plain.items()]
        rest = self._with("", **formulas)
        return ", ".join([head, *words, *([rest] if rest else [])])

    def _rotor_text(self, o: Rotor) -> str:
        head = f"on: {o.on}, m: {o.m!r} kg, e: {o.e!r} m, J: {o.J!r} kg m^2"
        return self._with(head, torque=o.torque) if o.torque is not None else head
