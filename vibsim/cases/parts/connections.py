"""Rules for what parts are tied to: bodies that exist, ground, and base where there is one."""

from collections.abc import Iterator

from vibsim.cases.parts.draft import Draft, Finding
from vibsim.cases.parts.ends import BASE, NO_BODIES
from vibsim.cases.problems import shown
from vibsim.cases.spelling import did_you_mean


def ends_exist(draft: Draft) -> Iterator[Finding]:
    """Each end is a body, ground or base."""
    allowed = [*(name for name in draft.bodies if name not in NO_BODIES), *NO_BODIES]
    for key, ends in draft.ends() if draft.bodies else ():
        for position, end in enumerate((ends.P, ends.Q), start=1):
            if end not in allowed:
                message = f"no body {shown(end)}{did_you_mean(end, allowed)}; allowed: {', '.join(allowed)}"
                yield Finding(f"{key}.between", message, at=f"{key}.between.{position}")


def ends_differ(draft: Draft) -> Iterator[Finding]:
    """A part joins two different ends, and one of them is a body."""
    for key, ends in draft.ends():
        if ends.P == ends.Q:
            message = f"joins {ends.P} to itself; a part needs two different ends"
            yield Finding(f"{key}.between", message)
        elif {ends.P, ends.Q} == set(NO_BODIES):
            message = f"joins {ends.P} to {ends.Q}; at least one end must be a body"
            yield Finding(f"{key}.between", message)


def base_is_there(draft: Draft) -> Iterator[Finding]:
    """Parts end at base where base moves, and only then."""
    tied = [key for key, ends in draft.ends() if BASE in (ends.P, ends.Q)]
    if "base" not in draft.values:
        for key in tied:
            message = "ends at base, and the case has none; give base: {a: ..., omega: ...}, or write ground"
            yield Finding(f"{key}.between", message)
    elif not tied:
        yield Finding("base", "no part ends at base; tie one to it, or leave base out", of_the_name=True)


def loads_act_on_bodies(draft: Draft) -> Iterator[Finding]:
    """Forces and the motor act on a body."""
    for key, part in [*draft.parts("forces"), ("motor", draft.section("motor"))]:
        on = part.get("on")
        if isinstance(on, str) and draft.bodies and on not in draft.bodies:
            allowed = ", ".join(draft.bodies)
            message = f"must be a body, got {shown(on)}{did_you_mean(on, draft.bodies)}; allowed: {allowed}"
            yield Finding(f"{key}.on", message)


def states_exist(draft: Draft) -> Iterator[Finding]:
    """States at t = 0 are those of bodies, and of the rotor under the name motor."""
    for key, part in draft.parts("initial"):
        name = key.partition(".")[2]
        if name == "motor":
            yield from _states_of_rotor(draft, part)
        elif draft.bodies and name not in draft.bodies:
            allowed = [*draft.bodies, "motor"]
            message = f"no body {shown(name)}{did_you_mean(name, allowed)}; allowed: {', '.join(allowed)}"
            yield Finding(key, message, of_the_name=True)
        else:
            for state in ("phi", "phidot"):
                if state in part:
                    message = "belongs to initial.motor; a body has x and v"
                    yield Finding(f"{key}.{state}", message, of_the_name=True)


def _states_of_rotor(draft: Draft, part: dict[str, object]) -> Iterator[Finding]:
    """The rotor has phi and phidot; without a motor an exact 0 says nothing and is let through."""
    for state in part:
        key = f"initial.motor.{state}"
        quantity = draft.quantity(key)
        if state in ("x", "v"):
            message = "the rotor has phi and phidot; x and v are those of the body under it"
            yield Finding(key, message, of_the_name=True)
        elif "motor" not in draft.values and quantity is not None and quantity.value != 0:
            yield Finding(key, f"there is no motor, so it must be left out, got {quantity}")
