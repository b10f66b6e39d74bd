"""The index check along branches of random scenes: what changes between two points is listed, or told of."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.orbits import search_orbits
from vibsim.orbits.branches.branch import Branch, branch_lines, facts, read_branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.special_points import UNRESOLVED

FEW, MANY = (0, 1), range(2, 40)


def random_case(seed, folder):
    """One or two bodies on springs before an elastic stop, with or without friction, driven by one force."""
    random = np.random.default_rng(seed)

    def number(low, high):
        return f"{low + (high - low) * random.random():.4g}"

    two, rubs = random.random() < 0.5, random.random() < 0.5
    bodies = ["m: 1 kg"] + [f"b: {number(0.5, 3)} kg"] * two
    links = [f"spring: {{between: [m, ground], k: {number(0.5, 2)} N/m, c: {number(0.02, 0.2)} N s/m}}"]
    if two:
        links.append(f"tie: {{between: [m, b], k: {number(0.5, 3)} N/m, c: {number(0.02, 0.2)} N s/m}}")
    stop = f"between: [m, ground], gap: {number(0.2, 1)} m, acts: compression, k: {number(3, 30)} N/m"
    text = [
        f"name: random-{seed}",
        f"bodies: {{{', '.join(bodies)}}}",
        f"links: {{{', '.join(links)}}}",
        f"stops: {{wall: {{{stop}, law: elastic}}}}",
        f"forces: {{drive: {{on: m, A: {number(0.2, 1)} N, omega: {number(0.5, 1.5)} rad/s}}}}",
        "run: {t_end: 400 s, every: 0.5 s}",
    ]
    if rubs:
        text.append(f"friction: {{floor: {{between: [m, ground], N: {number(0.02, 0.2)} N, mu: 1}}}}")
    path = folder / f"random-{seed}.yaml"
    path.write_text("\n".join(text))
    return load_case(str(path))


def checked(seed, folder, most):
    case = random_case(seed, folder)
    omega = float(case.quantity("drive.omega").value)
    start = search_orbits(case, count=2, seed=seed)[0]
    branch = continue_branch(start, "drive.omega", f"{0.7 * omega}:{1.4 * omega} rad/s", max_points=most)
    index = branch["index"]
    for i in range(len(branch) - 1):
        between = [one for one in branch.specials if one.between == (i, i + 1)]
        if not any(one.kind == UNRESOLVED for one in between):
            assert index[i + 1] - index[i] == sum(one.jump for one in between), branch["parameter"][i]
    return branch


@pytest.mark.parametrize("seed", FEW)
def test_what_changes_is_listed(seed, tmp_path):
    checked(seed, tmp_path, 60)


@pytest.mark.slow
@pytest.mark.parametrize("seed", MANY)
def test_what_changes_is_listed_at_length(seed, tmp_path):
    checked(seed, tmp_path, 120)


def test_it_is_told_in_words_and_on_file(tmp_path):
    """Where it does not hold the parameter is named: in what is printed, in JSON and in the file."""
    case = load_case("gallery/bilinear-oscillator", {"drive.A": "0.355 N"})
    path = tmp_path / "branch.h5"
    branch = continue_branch(case, "drive.A", "0.35:0.37 N", out=path)
    assert dict(branch_lines(branch))["index check"] == "holds everywhere"
    assert facts(branch)["unresolved"] == [] and read_branch(path).attrs["unresolved"] == 0
    points, (first, *rest) = branch.records
    doubtful = Branch(branch.plan, points, [replace(first, kind=UNRESOLVED), *rest], branch.attrs)
    told = dict(branch_lines(doubtful))["index check"]
    assert told.startswith("does not hold at 0.36") and told.endswith(" N")
    assert facts(doubtful)["unresolved"] == [doubtful.special("UR1").parameter]
    assert "index check     holds everywhere" in call("info", path).stdout
    assert json.loads(call("info", path, "--json").stdout)["unresolved"] == []
