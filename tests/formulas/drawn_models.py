"""Random scenes with formulas: as the text of a case, and as a model for the second solver.

Every number beside a formula has a unit, so the text also goes through the units of the language. Scales are
those of a body of some 1 kg on a spring of some 10 rad/s that moves by centimetres.
"""

from __future__ import annotations

import random

from tests.formulas.second_expressions import Law, law_of
from tests.formulas.second_model import Base, Force, Friction, Link, Model, Rotor, Stop


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

    def _spread(self, **limits):
        """Numbers with their units, as texts: of each the limits and the unit."""
        return {key: f"{spread(self.rng, *of)!r} {unit}" for key, (*of, unit) in limits.items()}

    def _even(self, **limits):
        return {key: f"{even(self.rng, *of)!r} {unit}".strip() for key, (*of, unit) in limits.items()}

    def _links(self) -> None:
        rng, names = self.rng, list(self.model.bodies)
        self.uses_base = rng.random() < 0.25
        ends = [("a", "base" if self.uses_base else "ground")]
        if "b" in names:
            ends.append(("b", "a"))
        for k, (P, Q) in enumerate(ends):
            self.model.links.append(Link(f"link{k}", P, Q, self._spring()))

    def _spring(self) -> Law:
        numbers = self._spread(k=(40, 300, "N/m"), d0=(5, 40, "mm"), c=(0.05, 2, "N s/m"))
        numbers |= {"F": "1.0 N", "v0": "0.1 m/s"}
        restoring = [
            "k*d",
            "k*d + k3*d**3",
            "k*d0*tanh(d/d0)",
            "k*d0*atan(d/d0)",
            "k*d0*sinh(0.3*(d/d0))",
            "k*d/sqrt(1 + (d/d0)**2)",
            "k*d*(1 + exp(0 - (d/d0)**2))",
            "k*d*(1 + log(1 + (d/d0)**2))",
            "k*d0*asin(0.6*tanh(d/d0))",
            "k*(max(d - d0, 0) + min(d + d0, 0))",
            "k*d*abs(d)/d0",
            "where(d < 0, k*d, kp*d)",
            "k*d*(1 + 0.4*cos(w0*t))",
            "k*d0*(cosh(d/d0) - 1)*(d/(d0 + abs(d)))",
            "F*table(d/d0, [[-2.0, -3.0], [-0.5, -1.0], [0.4, 0.9], [3.0, 6.0]], 'linear')",
        ]
        damping = ["c*v", "c*v + q*v*abs(v)", "c*v*(0.2 + (d/d0)**2)", "cf*tanh(v/v0)"]
        spring = self.rng.choice(restoring)
        if "k3" in spring:
            numbers |= self._spread(k3=(2e4, 5e5, "N/m^3"))
        if "kp" in spring:
            numbers |= self._spread(kp=(100, 900, "N/m"))
        if "w0" in spring:
            numbers |= self._even(w0=(0.5, 4, "Hz"))
        damper = self.rng.choice(damping)
        if "q" in damper:
            numbers |= self._spread(q=(0.5, 6, "N s^2/m^2"))
        if "cf" in damper:
            numbers |= self._spread(cf=(0.1, 1, "N"))
        return law_of(f"{spring} + ({damper})", numbers)

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
        numbers = self._spread(K=(3e3, 3e4, "N/m"), lam=(0.05, 1, "s/m"), KH=(3e4, 5e5, "N/m^1.5"))
        numbers |= self._spread(C=(1, 20, "N s/m"), K3=(1e7, 1e8, "N/m^3")) | {"l0": "10.0 mm"}
        laws = [
            "K*p + C*pv",
            "KH*p**1.5",
            "KH*p**1.5*(1 + lam*pv)",
            "K*l0*(p/l0)**2*(1 + lam*pv)",
            "K*l0*(p/l0)**2.5",
            "K*p + K3*p**3",
        ]
        law = rng.choice(laws)
        release = "force" if law is laws[0] and rng.random() < 0.5 else "gap"
        self.model.stops.append(Stop(name, *ends, gap, sense, law_of(law, numbers), release))

    def _frictions(self) -> None:
        rng, bodies = self.rng, list(self.model.bodies)
        if rng.random() < 0.5 or any(stop.e is not None for stop in self.model.stops):
            return
        self._friction("rub", rng.choice(bodies), "ground", rng.choice([0.0, 0.0, even(rng, -0.15, 0.15)]))
        if len(bodies) == 2 and rng.random() < 0.4:
            self._friction("between", "b", "a", 0.0)

    def _friction(self, name: str, P: str, Q: str, belt: float) -> None:
        rng = self.rng
        numbers = self._spread(n0=(1, 12, "N")) | self._even(wn=(0.3, 3, "Hz"))
        numbers |= self._spread(n1=(1, 12, "N"), kn=(50, 600, "N/m")) | self._even(tn=(0.3, 1.5, "s"))
        numbers |= self._spread(n2=(1, 12, "N")) | self._even(tau=(0.5, 2, "s"))
        numbers |= self._even(mu_s=(0.15, 0.3, ""), mu_d=(0.05, 0.15, ""), vs=(0.03, 0.2, "m/s"))
        loads = ["n0", "n0 + n1*sin(wn*t)", f"n0 - kn*x_{P}", "where(t < tn, n0, n2)", "n0*exp(0 - t/tau)"]
        falling = rng.choice(["exp(0 - (s/vs)**2)", "exp(0 - s/vs)", "1/(1 + s/vs)"])
        laws = ["mu_d", f"mu_d + (mu_s - mu_d)*({falling})"]
        static = rng.choice([1.0, 1.0, 1.2])
        load, mu = (law_of(rng.choice(texts), numbers) for texts in (loads, laws))
        self.model.frictions.append(Friction(name, P, Q, load, mu, static, belt))

    def _rotors(self) -> None:
        rng = self.rng
        if rng.random() < 0.65:
            return
        for name in ("left", "right")[: rng.choice([1, 1, 2])]:
            m, e, J = spread(rng, 0.02, 0.2), spread(rng, 10, 60), spread(rng, 1e-5, 1e-3)
            numbers = self._spread(T0=(0.005, 0.1, "N m")) | self._even(w0=(1, 5, "Hz")) | {"g": "9.81 m/s^2"}
            line, weight = "T0*(1 - w/w0)", "m*g*e*cos(phi)"
            torque = rng.choice([line, f"{line} - {weight}", f"0 - {weight}", None])
            start = even(rng, -3, 3), even(rng, -10, 20)
            on, law = rng.choice(list(self.model.bodies)), torque and law_of(torque, numbers)
            self.model.rotors.append(Rotor(name, on, m, e * 1e-3, J, law, *start))

    def _states(self) -> None:
        rng = self.rng
        if rng.random() < 0.6:
            return
        body = rng.choice(list(self.model.bodies))
        numbers = self._spread(u=(5, 20, "mm"), tau=(0.02, 0.5, "s"), r=(1, 5, "1/s"))
        numbers |= {"be": "0.6", "ga": "0.4", "q": "1.0 1/s"}
        rates = [
            f"v_{body} - (be*abs(v_{body})*z + ga*v_{body}*abs(z))/u",
            f"(x_{body} - z)/tau",
            f"r*x_{body} - abs(z)*z*q/u",
        ]
        self.model.states["z"] = (law_of(rng.choice(rates), numbers), 0.0)
        force = law_of("0 - kz*z", self._spread(kz=(20, 100, "N/m")))
        self.model.forces.append(Force("hysteresis", body, force))

    def _forces(self) -> None:
        rng = self.rng
        if rng.random() < 0.2:
            return
        numbers = self._spread(A=(0.3, 5, "N"))
        numbers |= self._even(w0=(0.5, 4, "Hz"), T1=(0.1, 0.7, "s"), T2=(0.8, 1.5, "s"))
        middle = f"[0.35 s, {even(rng, -4, 4)!r} N], [0.8 s, {even(rng, -4, 4)!r} N]"
        pairs = f"[[0.1 s, 0.0 N], {middle}, [1.3 s, 0.0 N]]"
        numbers |= self._even(r=(1, 10, "1/s^2"))
        laws = [
            "A*sin(w0*t)",
            "A*sin(w0*t + r*t**2)",
            "where(t < T1, A*sin(pi*t/T1), 0)",
            "A*step(t - T1)",
            "A*(step(t - T1) - step(t - T2))",
            "A*min(t/T1, 1)*sin(w0*t)",
            "A*exp(0 - t/T1)*cos(w0*t)",
            "A*(mod(t, T1)/T1 - 0.5)",
            "A*sign(sin(w0*t))",
            f"table(t, {pairs}, 'linear')",
            f"table(t, {pairs}, 'cubic')",
            "A*sin(w0*t)/(1 + (t/T1)**2)",
            "A*max(sin(w0*t), 0.2)",
        ]
        on = rng.choice(list(self.model.bodies))
        self.model.forces.append(Force("push", on, law_of(rng.choice(laws), numbers)))

    def _base(self) -> None:
        if self.uses_base:
            numbers = self._spread(a0=(1, 8, "mm")) | self._even(wb=(0.5, 3, "Hz"))
            motion = "a0*sin(wb*t)", "a0*wb*cos(wb*t)", "0 - a0*wb*wb*sin(wb*t)"
            self.model.base = Base(*(law_of(text, numbers) for text in motion))

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
    def _with(first: str, **laws: Law) -> str:
        """Keys of a part: its formulas, and the numbers beside them."""
        words = [first] if first else []
        words += [f'{key}: "{law.text}"' for key, law in laws.items()]
        words += [f"{name}: {value}" for law in laws.values() for name, value in law.numbers.items()]
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
        words = [f"between: [{o.P}, {o.Q}], static: {o.static!r}, belt: {o.belt!r} m/s"]
        for key, law in (("N", o.load), ("mu", o.mu)):
            plain = law.numbers.get(law.text)
            words.append(f"{key}: {plain}" if plain else self._with("", **{key: law}))
        return ", ".join(words)

    def _rotor_text(self, o: Rotor) -> str:
        head = f"on: {o.on}, m: {o.m!r} kg, e: {o.e!r} m, J: {o.J!r} kg m^2"
        return self._with(head, torque=o.torque) if o.torque is not None else head
