"""Names that a part may not have: every column and group that a file may hold."""

import h5py
import pytest

import vibsim
from vibsim.cases import CaseError
from vibsim.cases.case import load_case_text
from vibsim.cases.part_rules import COLUMNS, GROUPS, WORDS
from vibsim.orbits.orbit import save_orbit
from vibsim.results.simulation import simulate_to_file

SCENE = """
bodies: {{m: 1 kg}}
links: {{spring: {{between: [m, ground], k: 100 N/m}}}}
stops: {{{name}: {{between: [m, ground], law: rigid, e: 0.5, gap: 1 mm, acts: compression}}}}
motor: {{on: m, m3: 10 g, e: 1 cm, J: 1 g m^2, M0: 0.1 N m, Omega0: 5 Hz}}
run: {{t_end: 0.2 s, every: 10 ms}}
"""


def scene(name):
    return load_case_text(SCENE.format(name=name))


def names_in(path):
    """Names at the root of a file and of its events, but those of bodies and of the stop `wall`."""
    with h5py.File(path) as file:
        names = {*file, *file["events"]}
    return {name for name in names if name != "wall" and not name.endswith(("_m",))}


def test_all_columns_and_groups_of_files_are_taken(tmp_path):
    """With a motor, rigid stops, an estimate, digits, an orbit; and the column of the paper's stop."""
    simulate_to_file(scene("wall"), tmp_path / "run.h5")
    simulate_to_file(scene("wall"), tmp_path / "digits.h5", digits=20)
    simulate_to_file(scene("stop"), tmp_path / "stop.h5")
    save_orbit(vibsim.orbit("I-C"), tmp_path / "orbit.h5")
    names = set().union(*(names_in(tmp_path / f"{name}.h5") for name in ("run", "digits", "stop")))
    with h5py.File(tmp_path / "orbit.h5") as file:
        groups = {name for name in file if isinstance(file[name], h5py.Group)}
    assert names | groups == {*COLUMNS, *GROUPS}


@pytest.mark.parametrize("name", [*WORDS, *COLUMNS, *GROUPS])
def test_a_part_of_a_taken_name_is_refused_with_the_others(name):
    with pytest.raises(vibsim.CaseError) as caught:
        scene(name)
    (problem,) = caught.value.problems
    others = WORDS if name in WORDS else COLUMNS + GROUPS
    assert f"stops.{name}: the name is taken" in str(problem)
    assert all(other in str(problem) for other in others)


@pytest.mark.parametrize(("name", "what"), [("pi", "the number pi"), ("sin", "a function")])
def test_a_state_has_no_name_that_formulas_have(name, what):
    """A state pi was read in place of the number, without a word."""
    text = (
        f"bodies: {{m: 1 kg}}\nstates: {{{name}: {{rate: 1 1/s, start: 0}}}}\nrun: {{t_end: 1 s, every: 1 s}}"
    )
    with pytest.raises(CaseError, match=f"taken in formulas: {name} is {what}"):
        load_case_text(text)
