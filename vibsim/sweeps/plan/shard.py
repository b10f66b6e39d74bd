"""A large sweep shared out among several files: each part is a sweep of its own, along a part of one axis."""

from dataclasses import replace

from vibsim.sweeps.plan.sweep_plan import Plan, PlanError


def read_shard(text: str) -> tuple[int, int]:
    """Number of a part and of all parts from K/N. Raises PlanError."""
    first, _, last = text.partition("/")
    try:
        number, parts = int(first), int(last)
    except ValueError:
        number, parts = 0, 0
    if not 1 <= number <= parts:
        raise PlanError(f"a shard is written as K/N with K from 1 to N, such as 3/10, got {text}")
    return number, parts


def shard(plan: Plan, number: int, parts: int) -> Plan:
    """Part `number` of `parts` of a plan, counted from 1; its points are those of the whole, bit for bit.

    Its longest axis is cut; not the first one where a state is carried along it. Raises PlanError where that
    has not so many values.
    """
    free = range(1 if plan.carry else 0, len(plan.axes))
    if not free:
        raise PlanError("a state is carried from point to point along the only axis, so it cannot be cut")
    cut = max(free, key=lambda i: len(plan.axes[i]))
    axis = plan.axes[cut]
    if parts > len(axis):
        raise PlanError(f"the longest axis that can be cut, {axis.name}, has {len(axis)} values, not {parts}")
    begin, end = (len(axis) * i // parts for i in (number - 1, number))
    axes = [axis.part(begin, end) if i == cut else other for i, other in enumerate(plan.axes)]
    return replace(plan, axes=tuple(axes))
