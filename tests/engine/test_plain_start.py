"""Modes of plain starts against the automaton, which decides all of them."""

from dataclasses import replace

import pytest
from hypothesis import given, settings

from tests.engine.random_parts import part_scenes
from tests.engine.test_closed_cases import scene
from vibsim.engine.errors import start_of
from vibsim.engine.events.automaton import Automaton, UnambiguousStart
from vibsim.engine.events.departures import derivative_flow
from vibsim.engine.events.records import Certificate
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import COMPRESSION, GROUND, Body, Friction, Stop


def decided(of):
    """(mode, known zeros, doubts) of the start by the automaton; the mode by signs alone, or None."""
    maker, certificate = RowMaker(of, Doubles), Certificate(Doubles)
    automaton = Automaton(of, maker, derivative_flow(of, Doubles, certificate), Doubles)
    plain = UnambiguousStart(of, maker.ends)
    status = plain.status(start_of(of, Doubles)) if plain.known else None
    return (*automaton.initial(start_of(of, Doubles)), certificate.uncertified), status


@settings(max_examples=80)
@given(part_scenes())
def test_a_plain_start_is_what_the_automaton_says(of):
    of = replace(of, stops=tuple(replace(stop, at_start=False) for stop in of.stops))
    (status, known, doubts), plain = decided(of)
    assert plain is None or (plain, {}, 0) == (status, known, doubts)


@pytest.mark.parametrize(
    ("x", "v", "plain"),
    [
        (0.1, 0.5, True),
        (0.3, -0.5, True),
        (0.2, 0.5, False),  # at the stop
        (0.2 + 2.0**-54, 0.5, False),  # within its rounding
        (0.1, 0.0, False),  # at rest
        (0.1, 2.0**-60, True),
    ],
)
def test_which_starts_are_plain(x, v, plain):
    stop, rub = (
        Stop("wall", 0, GROUND, 0.2, COMPRESSION, 50.0, 0.0),
        Friction("rub", 0, GROUND, 1.0, 1.0, 0.0),
    )
    of = scene([Body("m", 1.0, x, v)], stops=(stop,), frictions=(rub,))
    (status, _, _), by_signs = decided(of)
    assert (by_signs is not None) == plain and by_signs in (None, status)
