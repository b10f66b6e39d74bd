"""Branches along which a motion begins to stick, and where it does over two parameters."""

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.locus_result import Locus, LocusStore, locus_plan, read_locus
from vibsim.orbits.branches.plan import BranchError, read_span
from vibsim.orbits.branches.special_points import held
from vibsim.orbits.search import orbit
from vibsim.plots.registry import kind_named
from vibsim.plots.subject import Subject, View
from vibsim.results.hdf5_reading import ResultFileError

COULOMB = """
name: coulomb
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m}}
friction: {floor: {between: [m, ground], N: 0.1 N, mu: 1}}
forces: {drive: {on: m, A: 0.15 N, omega: 0.7 rad/s}}
stops: {buffer: {between: [m, ground], gap: 9 m, acts: compression, law: elastic, k: 0.2 N/m}}
run: {t_end: 400 s, every: 0.5 s}
"""


def without_stops(w, force=0.1):
    """Amplitude of the force below which the oscillator of Den Hartog (1931) sticks where it turns round [N].

    Sliding all the time its amplitude is x with (k x)^2 = (A V)^2 - (F U)^2, V = 1 / (1 - w^2) and
    U = sin(pi / w) / (w (1 + cos(pi / w))), and where it turns k x - A cos(phase) = k x w^2 = F at the limit.
    """
    U = np.sin(np.pi / w) / (w * (1 + np.cos(np.pi / w)))
    return force * np.sqrt(U**2 + w**-4.0) * np.abs(1 - w**2)


@pytest.fixture(scope="module")
def coulomb():
    return load_case(COULOMB)


@pytest.fixture(scope="module")
def branch(coulomb):
    return continue_branch(coulomb, "A", "0.13:0.15 N")


def locus_of(branch, key, span, most, path=None):
    return complete(LocusStore(locus_plan(branch, "ST1", *read_span(branch.case, key, span)), path), most)[0]


def test_it_begins_to_stick_where_den_hartog_says(branch):
    assert [(one.kind, branch.spelled(one.after)) for one in branch.specials][-1] == ("sticking", "rr")
    for one in branch.specials:
        assert one.parameter == pytest.approx(without_stops(0.7), rel=1e-12)


def test_sticks_over_two_parameters(branch, tmp_path):
    locus = locus_of(branch, "drive.omega", "0.55:0.9 rad/s", 9, tmp_path / "locus.h5")
    assert locus.kind == "sticking" and np.ptp(locus["second"]) > 0.04
    np.testing.assert_allclose(locus["parameter"], without_stops(locus["second"]), rtol=1e-12)
    assert read_locus(tmp_path / "locus.h5").points == locus.points
    of_its_own = Locus(locus.plan, locus.points)  # as of a locus that no file holds
    assert read_locus(of_its_own.save(tmp_path / "saved.h5")).points == locus.points
    with pytest.raises(ResultFileError, match="exists"):
        locus.save(tmp_path / "saved.h5")
    whole = locus_of(branch, "drive.omega", "0.55:0.9 rad/s", 12, tmp_path / "saved.h5")
    assert len(whole) == 12 and [p for p in whole.points if p in locus.points] == locus.points
    figure = kind_named("locus").draw([Subject("l.h5", "l", "locus", locus.case, locus)], View())
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["stick phases that come or go"]


@pytest.mark.slow
def test_sticks_of_a_motion_that_is_not_symmetric(coulomb):
    """With a buffer on one side that side sticks first; other branches find it where the locus is."""
    buffered = coulomb.with_values({"stops.buffer.gap": "0 m"})
    branch = continue_branch(buffered, "A", "0.13:0.15 N")
    assert [branch.spelled(one.after).count("s") for one in branch.specials] == [1]
    locus = locus_of(branch, "drive.omega", "0.69:0.71 rad/s", 40)
    assert locus.ends == ("end of the range", "end of the range")
    for i in (0, -1):
        beside = buffered.with_values({"forces.drive.omega": f"{float(locus['second'][i])!r} rad/s"})
        there = continue_branch(beside, "A", "0.13:0.15 N").special("ST1")
        assert there.parameter == pytest.approx(locus["parameter"][i], rel=1e-12)


def test_what_of_a_stick_is_followed():
    """A reversal of one friction that becomes a stick, or the other way, one or more at once; no touch."""
    r, s, u = (("reversal", 0), ("stick_begin", 0), ("stick_end", 0))
    other = ("reversal", 1)
    assert held((r, other), (other, s, u)) == held((s, u), (r,)) == held((r, r), (s, u, s, u)) == 0
    assert held((), (s, u)) is held((r, r), (s, u)) is held((other,), (s, u)) is None


def test_a_stick_that_is_born_from_a_touch_is_refused_in_words(branch, monkeypatch):
    special = branch.special("ST1")
    monkeypatch.setitem(vars(special), "before", ())
    monkeypatch.setitem(vars(special), "after", (("stick_begin", 0), ("stick_end", 0)))
    words = "ST1: loci are followed where a reversal of one friction becomes a stick"
    with pytest.raises(BranchError, match=words):
        locus_of(branch, "drive.omega", "0.6:0.8 rad/s", 3)


def test_a_motion_that_begins_to_stick_on_both_sides_at_once_is_followed_fast(monkeypatch):
    """Its own mirror image sticks at both reversals at one frequency: one change, that no halving parts.

    It is located in some ten motions.
    """
    counts, call = [0], Family.__call__

    def counted(self, z):
        counts[0] += 1
        return call(self, z)

    start = orbit("gallery/friction-oscillator", {"floor.static": "1.1", "drive.omega": "0.76 rad/s"})
    monkeypatch.setattr(Family, "__call__", counted)
    branch = continue_branch(start, "drive.omega", "0.74:0.77 rad/s")
    (special,) = branch.specials
    words = [branch.spelled(word) for word in (special.before, special.after)]
    assert special.kind == "sticking" and words == ["susu", "rr"]
    assert counts[0] < 60


def test_orbits_at_rest_are_followed_in_long_steps():
    """Below A = mu N = 1 N the block rests anywhere in a range: a family, in which no cubic through orbits
    tells the next. Steps shrank to 1e-8 again and again, 800 in place of a few.
    """
    branch = continue_branch("gallery/friction-oscillator", "drive.A", "0.9:1.6 N")
    resting = branch["word"] == ""
    assert branch["parameter"].min() == pytest.approx(0.9) and 2 <= resting.sum() < 20
    assert np.abs(branch["parameter"][resting]).max() <= 1.0


def test_what_sticks_on_a_shaken_base_across_the_section_goes_on_sticking():
    """A period later the lower block has the velocity of the table but for rounding. It began with a slip of
    that, and stuck at once: 14 places where such a stick came or went were told. Of itself it sticks until
    the table's acceleration, with the friction of the upper block, asks more than friction holds.
    """
    start = orbit(load_case("gallery/stack-of-blocks", {"base.a": "6.5 mm"}))
    branch = continue_branch(start, "base.a", "5:8.5 mm")
    first, second = branch.specials
    held = (0.35 * 58.86 - 0.1 * 9.81) / 5 / (8 * np.pi) ** 2
    assert first.parameter * 1e-3 == pytest.approx(held, rel=1e-11) and first.kind == "sticking"
    assert [branch.spelled(word) for word in (first.before, first.after)] == ["r3 r3", "r3 u1 s1 r3 u1 s1"]
    assert second.kind == "order" and not any(one.kind == "unresolved" for one in branch.specials)
