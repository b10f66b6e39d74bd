"""Keys that stand in place of one another: the one that a child or an override gives drops the other."""

from collections.abc import Collection

ALTERNATIVES: dict[str, tuple[tuple[frozenset[str], frozenset[str]], ...]] = {
    "friction": (
        (frozenset({"N"}), frozenset({"g"})),
        (frozenset({"mu", "static", "mu_s", "mu_d", "d", "v0"}), frozenset({"plus", "minus"})),
        (frozenset({"mu", "static"}), frozenset({"mu_s", "mu_d", "d", "v0"})),
        (frozenset({"d"}), frozenset({"v0"})),
    ),
    "stops": ((frozenset({"e"}), frozenset({"k", "c", "release"})),),
    "forces": ((frozenset({"terms"}), frozenset({"A", "omega", "phase"})),),
    "base": ((frozenset({"terms"}), frozenset({"a", "omega", "phase"})),),
}
DEPTH = {"stops": 2, "friction": 2, "forces": 2, "base": 1}  # of the dotted key of the part that has them


def superseded(part: str, keys: Collection[str]) -> set[str]:
    """Keys of a part, such as "friction.guide", that give way when `keys` are set over it."""
    section, *names = part.split(".")
    out: set[str] = set()
    if DEPTH.get(section) != len(names) + 1:
        return out
    for one, other in ALTERNATIVES[section]:
        for new, old in ((one, other), (other, one)):
            if new & set(keys) and not old & set(keys):
                out |= old
    return out
