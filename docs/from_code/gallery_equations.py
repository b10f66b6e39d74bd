"""The equations of motion of a case of the gallery, as LaTeX, from its file."""

import ast
import re
from typing import Any

import yaml

GREEK = ("alpha", "beta", "gamma", "theta", "omega", "phi", "mu", "zeta")
SPELLED = {"Omega0": r"\Omega_0", "be": r"\beta", "ga": r"\gamma"}
BREAK = r";\qquad "  # between formulas of one law, which narrow pages cannot hold beside each other
LONGEST_ROW = 100  # signs in print, those of indices too
STATE = re.compile(r"^([xv])_(\w+)$")


def equations(text: str) -> str:
    """Displayed formulas: one for each body, state and rotor, then what each stop and friction does."""
    scene = Scene(yaml.load(text, Loader=yaml.BaseLoader))  # every value is a text; `on` is no boolean
    rows = [row for line in scene.lines() for law in line.split(BREAK) for row in folded(law)]
    return "\n\n".join(f"$$\n{row}\n$$" for row in rows)


def folded(formula: str) -> list[str]:
    """A sum as rows of at most some 100 signs, broken before terms; a law with its condition is one row."""
    if r"\quad" in formula:
        return [formula]
    terms = [""]
    depth = 0
    for piece in re.split(r"( [+-] |[{}()])", formula):
        depth += {"{": 1, "(": 1, "}": -1, ")": -1}.get(piece, 0)
        if piece in (" + ", " - ") and depth == 0:
            terms.append("")
        terms[-1] += piece
    rows = [""]
    for term in terms:
        if rows[-1] and printed_length(rows[-1] + term) > LONGEST_ROW:
            rows.append(r"\qquad")
        rows[-1] += term
    return rows


def printed_length(formula: str) -> int:
    """How many signs a formula has in print, commands as one."""
    return len(re.sub(r"\\[a-z]+|[{}\\_^ ]", "x", formula.replace(r"\text", "")).replace("xx", "x"))


class Scene:
    """The parts of a case file, and the symbols of their numbers."""

    def __init__(self, parts: dict[str, Any]):
        self.parts = parts
        self.bodies = [str(name) for name in parts["bodies"]]
        self.torsional = any("m^2" in str(mass) for mass in parts["bodies"].values())

    def section(self, name: str) -> dict[str, Any]:
        return {str(key): part for key, part in (self.parts.get(name) or {}).items()}

    def lines(self) -> list[str]:
        """All equations, in the order in which they are read."""
        lines = [self.of_body(name) for name in self.bodies]
        states = self.section("states").items()
        lines += [rf"\dot{{{symbol(name)}}} = {self.formula(part['rate'], {})}" for name, part in states]
        if "motor" in self.parts:
            lines += [self.of_rotor("", self.parts["motor"], str(self.parts["motor"]["on"]))]
        lines += [self.of_rotor(name, part, str(part["on"])) for name, part in self.section("rotors").items()]
        lines += [self.of_stop(name, part) for name, part in self.section("stops").items()]
        lines += [self.of_friction(name, part) for name, part in self.section("friction").items()]
        base = self.parts.get("base")
        if base:
            lines.append(f"x_b = {self.formula(base['x'], {}) if 'x' in base else harmonic('a', base)}")
        return lines

    # Coordinates.

    def x(self, end: str, dots: str = "") -> str:
        """The displacement of an end, or its rate with dots "\\dot"; empty for the ground."""
        if end == "ground":
            return ""
        index = "_b" if end == "base" else "" if len(self.bodies) == 1 else f"_{{{label(end)}}}"
        letter = r"\theta" if self.torsional else "x"
        return f"{dots}{{{letter}}}{index}" if dots else f"{letter}{index}"

    def relative(self, ends: Any, dots: str = "") -> str:
        """x_P - x_Q of two ends."""
        first, second = (self.x(str(end), dots) for end in ends)
        return f"{first} - {second}" if second else first

    def bracketed(self, ends: Any, dots: str = "") -> str:
        relative = self.relative(ends, dots)
        return f"({relative})" if " - " in relative else relative

    # Equations.

    def of_body(self, name: str) -> str:
        """Inertia on the left, all forces on the right."""
        mass = ("J" if self.torsional else "m") + (f"_{{{label(name)}}}" if len(self.bodies) > 1 else "")
        motor = self.parts.get("motor")
        carried = ["m_3"] if motor and str(motor["on"]) == name else []
        rotors = self.section("rotors").items()
        carried += [f"m_{{{label(key)}}}" for key, each in rotors if str(each["on"]) == name]
        if carried:
            mass = f"({' + '.join([mass, *carried])})"
        terms: list[str] = []
        for key, link in self.section("links").items():
            terms += self.signed(name, link["between"], self.of_link(key, link), -1)
        for key, stop in self.section("stops").items():
            sign = 1 if stop["acts"] == "extension" else -1
            terms += self.signed(name, stop["between"], [f"F_{{{label(key)}}}"], sign)
        for key, friction in self.section("friction").items():
            terms += self.signed(name, friction["between"], [f"R_{{{label(key)}}}"], 1)
        for key, force in self.section("forces").items():
            if str(force["on"]) == name:
                terms += self.of_force(key, force)
        rotors = {**self.section("rotors"), **({"": motor} if motor else {})}
        for key, rotor in rotors.items():
            if str(rotor["on"]) == name:
                terms.append(thrust(key))
        right = " ".join(terms) or "0"
        return rf"{mass}\,{self.x(name, chr(92) + 'ddot')} = {right.removeprefix('+ ')}"

    def signed(self, body: str, between: Any, terms: list[str], sign: int) -> list[str]:
        """Terms of a part between two ends as they act on a body: against each other on the two."""
        ends = [str(end) for end in between]
        if body not in ends:
            return []
        way = sign if ends[0] == body else -sign
        return [with_sign(term, way) for term in terms]

    def of_link(self, name: str, link: dict[str, Any]) -> list[str]:
        """The terms of a link's force."""
        several = len(self.section("links")) > 1
        if "force" in link:
            numbers = {"d": self.bracketed(link["between"]), "v": self.bracketed(link["between"], r"\dot")}
            formula = self.formula(link["force"], numbers)
            return [rf"\left({formula}\right)"]
        index = f"_{{{label(name)}}}" if several else ""
        terms = []
        if "k" in link:
            terms.append(f"k{index}\\,{self.bracketed(link['between'])}")
        if "c" in link:
            terms.append(f"c{index}\\,{self.bracketed(link['between'], chr(92) + 'dot')}")
        return terms

    def of_force(self, name: str, force: dict[str, Any]) -> list[str]:
        """The terms of a force on a body."""
        index = f"_{{{label(name)}}}" if len(self.section("forces")) > 1 else ""
        if "force" in force:
            return [with_sign(rf"\left({self.formula(force['force'], {})}\right)", 1)]
        terms = [with_sign(f"F_{{0{',' + label(name) if index else ''}}}", 1)] if "F0" in force else []
        if "A" in force:
            terms.append(with_sign(harmonic(f"A{index}", force), 1))
        return terms

    def of_rotor(self, name: str, rotor: dict[str, Any], body: str) -> str:
        """The turning of a rotor: inertia, the body under it, and its torque."""
        index = f"_{{{label(name)}}}" if name else ""
        mass = "m_3" if not name else f"m{index}"
        phi, rate = rf"\varphi{index}", rf"\dot{{\varphi}}{index}"
        inertia = rf"(J{index} + {mass} e{index}^2)\,\ddot{{\varphi}}{index}"
        coupling = rf"{mass} e{index}\,{self.x(body, chr(92) + 'ddot')} \sin{{{phi}}}"
        if "torque" in rotor:
            torque = self.formula(rotor["torque"], {"phi": phi, "w": rate})
        elif "M0" in rotor:
            torque = rf"M_{{0{label(name)}}} (1 - {rate}/\Omega_{{0{label(name)}}})"
        else:
            torque = "0"
        return rf"{inertia} = {coupling}" + (f" {plus(torque)}" if torque != "0" else "")

    def of_stop(self, name: str, stop: dict[str, Any]) -> str:
        """What a stop does, in its depth p."""
        index = label(name)
        relative = self.relative(stop["between"])
        depth = (
            f"{relative} - g_{{{index}}}"
            if stop["acts"] == "compression"
            else f"-({relative}) - g_{{{index}}}"
        )
        if stop.get("law") == "rigid":
            impact = rf"\dot p^+ = -e_{{{index}}}\,\dot p^- \quad\text{{at }} p = {depth} = 0"
            return rf"{impact}{BREAK}F_{{{index}}} = 0 \quad\text{{while }} p < 0"
        if "force" in stop:
            force = self.formula(stop["force"], {"p": "p", "pv": r"\dot p"})
        else:
            force = f"k_{{{index}}}\\,p" + (rf" + c_{{{index}}}\,\dot p" if "c" in stop else "")
        if stop.get("release") == "force":
            force = rf"\max(0, {force})"
        return rf"F_{{{index}}} = {force} \quad\text{{while }} p = {depth} > 0"

    def of_friction(self, name: str, friction: dict[str, Any]) -> str:
        """Coulomb's law, set-valued at rest."""
        index = label(name)
        slip = self.relative(friction["between"], r"\dot") + (
            f" - V_{{{index}}}" if "belt" in friction else ""
        )
        load = f"({self.formula(friction['N'], {})})" if is_formula(friction.get("N")) else f"N_{{{index}}}"
        falling = r"(v)" if "mu_s" in friction else ""
        limit = rf"\mu_{{{index}}}{falling}\,{load}"
        return (
            rf"R_{{{index}}} = -{limit}\,\operatorname{{sgn}} v,\quad v = {slip} \ne 0{BREAK}"
            rf"|R_{{{index}}}| \le {limit.replace('(v)', '(0)')}\quad\text{{while }} v = 0"
        )

    def formula(self, text: str, names: dict[str, str]) -> str:
        """A formula of the file as LaTeX."""
        return latex(ast.parse(str(text), mode="eval").body, lambda name: names.get(name) or self.name(name))

    def name(self, name: str) -> str:
        state = STATE.match(name)
        if state and state[2] in self.bodies:
            return self.x(state[2], r"\dot" if state[1] == "v" else "")
        speed = r"\dot\varphi" if "motor" in self.parts else r"\omega"
        return {"w": speed, "phi": r"\varphi"}.get(name) or symbol(name)


def thrust(name: str) -> str:
    """What the unbalance of a rotor does to its body."""
    index = f"_{{{label(name)}}}" if name else ""
    mass = f"m{index}" if name else "m_3"
    phi = rf"\varphi{index}"
    rates = rf"\ddot{{\varphi}}{index}", rf"{{\dot{{\varphi}}{index}}}^2"
    return rf"+ {mass} e{index} ({rates[0]} \sin{{{phi}}} + {rates[1]} \cos{{{phi}}})"


def harmonic(amplitude: str, part: dict[str, Any]) -> str:
    phase = str(part.get("phase", ""))
    if phase == "90 deg":
        return rf"{amplitude} \cos\omega t"
    if phase == "180 deg":
        return rf"{amplitude} \sin(\omega t + \pi)"
    return rf"{amplitude} \sin(\omega t + \psi)" if phase else rf"{amplitude} \sin\omega t"


def label(name: str) -> str:
    """A name as an index."""
    short = name.replace("_", r"\,")
    return (
        short if len(name) == 1 or name.isdigit() else rf"\text{{{name.replace('_', ' ')}}}" if name else ""
    )


def symbol(name: str) -> str:
    """The symbol of a number: its first letter or Greek name, what follows as an index."""
    if name in GREEK:
        return rf"\{name}"
    if name in SPELLED:
        return SPELLED[name]
    match = re.fullmatch(r"([A-Za-z])_?(\w*)", name)
    if match and match[2]:
        return rf"{match[1]}_{{{match[2] if match[2].isdigit() else rf'{chr(92)}text{{{match[2]}}}'}}}"
    return name


def with_sign(term: str, sign: int) -> str:
    return f"{'+' if sign > 0 else '-'} {term}"


def plus(terms: str) -> str:
    """Terms behind others."""
    return terms if terms.startswith("-") else f"+ {terms}"


def is_formula(value: Any) -> bool:
    return isinstance(value, str) and re.fullmatch(r"[-\d.e/]+ .*", value) is None and not value[:1].isdigit()


# Formulas: what Python reads as an expression.

SIGNS = {ast.Add: "+", ast.Sub: "-"}
ORDER = {ast.Add: 1, ast.Sub: 1, ast.Mult: 2, ast.Div: 2, ast.USub: 2, ast.Pow: 3}
NAMED = {"sin", "cos", "exp", "max", "min"}


def rank(node: ast.expr) -> int:
    """How strongly an expression holds together."""
    if isinstance(node, ast.BinOp | ast.UnaryOp):
        return ORDER[type(node.op)]
    return 4


def latex(node: ast.expr, name: Any) -> str:
    """An expression as LaTeX; `name` gives the symbol of a name."""
    match node:
        case ast.Constant(value=value):
            return f"{value:g}"
        case ast.Name(id=word):
            return str(name(word))
        case ast.UnaryOp(operand=operand):
            return f"-{bracketed(operand, 2, name)}"
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return rf"\frac{{{latex(left, name)}}}{{{latex(right, name)}}}"
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            return f"{bracketed(left, 4, name)}^{{{latex(right, name)}}}"
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return rf"{bracketed(left, 2, name)}\,{bracketed(right, 2, name)}"
        case ast.BinOp(left=left, op=op, right=right):
            return f"{latex(left, name)} {SIGNS[type(op)]} {bracketed(right, 2, name)}"
        case ast.Compare(left=left, ops=[_], comparators=[right]):
            return f"{latex(left, name)} < {latex(right, name)}"
        case ast.Call(func=ast.Name(id="abs"), args=[inner]):
            return rf"|{latex(inner, name)}|"
        case ast.Call(func=ast.Name(id="where"), args=[when, then, otherwise]):
            cases = [latex(each, name) for each in (then, when, otherwise)]
            return rf"\left\{{{cases[0]} \;\text{{if }} {cases[1]},\; \text{{else }} {cases[2]}\right\}}"
        case ast.Call(func=ast.Name(id=word), args=args):
            inner = ", ".join(latex(each, name) for each in args)
            return rf"\{word}({inner})" if word in NAMED else rf"\text{{{word}}}({inner})"
    raise ValueError(f"no LaTeX for {ast.dump(node)}")


def bracketed(node: ast.expr, least: int, name: Any) -> str:
    text = latex(node, name)
    return rf"\left({text}\right)" if rank(node) < least else text
