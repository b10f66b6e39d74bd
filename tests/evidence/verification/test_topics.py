"""The hard cases move as their headers say."""

from functools import cache

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.evidence.verification.checks import run
from vibsim.physics.parts import EVENT_KINDS


@cache
def moved(name):
    return run(load_case(f"hard/{name}"), "c")


def events(name, kind):
    """The rows of one kind of event."""
    result = moved(name)
    rows = result.events["kind"] == EVENT_KINDS[kind]
    return {column: values[rows] for column, values in result.events.items()}


def test_friction_holds_most_of_the_time():
    assert np.mean(moved("mostly-stuck")["friction"] == 0) > 0.75
    assert len(events("mostly-stuck", "stick_end")["t"]) >= 50


def test_contact_is_lost_in_stick():
    ends = events("contact-lost-while-stuck", "contact_end")
    assert len(ends["t"]) >= 50 and np.all(ends["friction"] == 0)


def test_contact_is_lost_in_the_moment_of_sticking():
    (first,) = events("contact-lost-as-it-sticks", "contact_end")["t"][:1]
    assert abs(events("contact-lost-as-it-sticks", "stick_begin")["t"] - first).min() < 1e-16


def test_chatter_dies_out():
    begins = events("chatter", "contact_begin")
    ends = events("chatter", "contact_end")["t"]
    count = len(ends)
    flights = begins["t"][1:] - ends[: len(begins["t"]) - 1]
    assert count > 100
    assert flights[-1] < flights[0] / 100
    assert moved("chatter")["contact"][-1] == 1


def test_releases_at_the_peak_move_nothing():
    # 64 touches, each rounding x2 beside an x1 of 5 mm
    assert abs(moved("release-at-the-peak")["x2"]).max() < 64 * 2.0**-52 * 5e-3


def test_slips_beside_the_peak_are_short():
    ends, begins = (events("release-beside-the-peak", kind)["t"] for kind in ("stick_end", "stick_begin"))
    assert len(ends) == len(begins) == 64
    assert np.all((20 * (begins - ends) > 5e-5) & (20 * (begins - ends) < 2e-4))


@pytest.mark.parametrize(("name", "low", "high"), [("capture", 3.4, 4.2), ("passage", 6.0, 6.5)])
def test_the_separatrix_parts_capture_from_passage(name, low, high):
    """Both follow the same motion to 1 % until 4 s."""
    speed = moved(f"separatrix-{name}")["phidot"] / (2 * np.pi)
    assert np.all((low < speed[-50:]) & (speed[-50:] < high))
    other = moved("separatrix-capture")["phidot"] / (2 * np.pi)
    assert np.allclose(speed[:80], other[:80], rtol=0.01)


def test_many_turns_lie_between_two_impacts_of_the_fast_source():
    gaps = np.diff(events("fast-source", "contact_begin")["t"])
    assert gaps.max() * 1000 > 100


def test_contacts_of_the_stiff_stop_are_short():
    begins, ends = (events("stiff-stop", f"contact_{kind}")["t"] for kind in ("begin", "end"))
    assert (ends - begins[: len(ends)]).max() < 60e-6


def test_a_preloaded_run_starts_in_contact():
    assert moved("preloaded-stop")["contact"][0] == 1
    assert events("preloaded-stop", "contact_end")["t"][0] < 0.01


@pytest.mark.parametrize(
    "name",
    [
        "stiff-stop",
        "critical-damping",
        "overdamped",
        "undamped-resonance",
        "no-coupling-spring",
        "slow-source",
        "light-block-1",
        "heavy-block-1",
    ],
)
def test_there_are_impacts(name):
    assert moved(name).attrs["impacts"] >= 5
