"""The paper's own words: short quotes with their places, the only ones that the report may use.

Each was read in the paper's text. Whoever changes or adds one reads it there again, and then brings the
fingerprint in tests/evidence/reports/test_quotes.py up to date.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quote:
    """A few words of the paper, and where they stand."""

    text: str
    place: str


QUOTES = {
    # the models
    "control values": Quote(
        "the first value (3.5 Hz) is below the natural frequency, the second (5.5 Hz) and the third (6.5 Hz) "
        "are above the value of the natural frequency of the vibro-impact model (ωn = 4.1 Hz)",
        "Section 2.2",
    ),
    "similar force": Quote(
        "the force of the non-ideal excitation is similar to the force of the ideal excitation", "Section 2.2"
    ),
    "amplitude": Quote("A = m3eω²", "Eq. (2.11)"),
    "no transition": Quote(
        "The system behaves periodically when there is no abrupt stiffness transition in the two-stage "
        "spring",
        "Section 2.1",
    ),
    "voltage": Quote(
        "Its variation is achieved by altering the current or voltage on the electric motor", "Section 2.2"
    ),
    "torque constant kept": Quote(
        "The torque constant was kept fixed and the angular velocity constant of the motor", "Section 2.2"
    ),
    # regimes
    "chaotic": Quote("For certain values of the parameters of the system, the motion is chaotic", "Abstract"),
    "responses": Quote(
        "the system shows periodic, quasi-periodic and chaotic responses, with and without the occurrence of "
        "abrupt transition of stiffness",
        "Section 2.1",
    ),
    "regular": Quote(
        "both types of excitation, the phase planes tend to become more regular with higher excitation "
        "frequencies",
        "Section 3",
    ),
    "period-1": Quote("with one impact at every cycle (period-1 limit-cycle) at 6.5 Hz", "Section 3"),
    # impacts
    "impacts more frequent": Quote(
        "As the frequency is increased and reaches 6.5 Hz, the impacts are more frequent and start occurring "
        "at every cycle",
        "Section 3",
    ),
    "number of impacts": Quote(
        "the number of impacts does not change considerably compared to the situation with 5.5 Hz",
        "Section 3",
    ),
    "very different": Quote(
        "the models present very different results according to the type of the excitation source, ideal or "
        "non-ideal, regarding the number of impacts and the rate of displacement",
        "Section 3",
    ),
    # drift and size
    "overall rate": Quote(
        "The overall displacement rate of the system increases reasonably as the frequency is increased",
        "Section 3",
    ),
    "cause": Quote("This can be the cause of the perceived increase in the displacement rate", "Section 3"),
    "rates higher": Quote(
        "The displacement rates are considerably higher than for the system with ideal excitation, and this "
        "happens for all analysed frequencies",
        "Section 3",
    ),
    "rate tends": Quote(
        "The displacement rate also tends to increase with higher excitation frequencies", "Section 3"
    ),
    "higher at 5.5": Quote("the situation with 5.5 Hz, which has a higher displacement rate", "Section 3"),
    "until 170 s": Quote(
        "at 6.5 Hz, the displacement increases rapidly until around 170 s, and after that it starts "
        "decreasing",
        "Section 3",
    ),
    "much larger": Quote(
        "The displacements and velocities are much larger for the non-ideal excitation source model",
        "Section 3",
    ),
    "values much larger": Quote(
        "presents values of displacement and velocity much larger in relation to the model with the ideal "
        "excitation source",
        "Section 4",
    ),
    # the motor
    "equilibrium": Quote(
        "Each characteristic curve shows that the motor reaches equilibrium for the system operating at "
        "different angular velocities",
        "Section 2.2",
    ),
    "determines a speed": Quote(
        "Each characteristic curve of the motor determines an angular velocity of the motor axis where the "
        "motor reaches the steady state",
        "Section 2.2",
    ),
    "additional power": Quote(
        "additional power supplied to the motor will only increase the amplitude of the oscillating system "
        "response, with little effect on the angular velocity of the energy source",
        "Section 1",
    ),
    "steady state": Quote(
        "the motor has reached a steady state angular frequency similar to the angular velocity constant of "
        "the motor",
        "Section 4",
    ),
    "Sommerfeld": Quote(
        "in the second and third situations, the motor exhibits the Sommerfeld effect", "Section 4"
    ),
    "cannot escape": Quote(
        "the angular velocity of the motor is captured by the resonance frequency of 4.1 Hz, from which the "
        "motor cannot escape",
        "Section 3",
    ),
    "cannot exceed": Quote(
        "the motor was captured by resonance (4.1 Hz) and cannot exceed this frequency", "Section 3"
    ),
    "initially captured": Quote("the motor is initially captured by resonance at 4.1 Hz", "Section 3"),
    "jumps": Quote(
        "after approximately 100 seconds, the motor reaches a sufficient condition to overcome this "
        "frequency and jumps to a frequency of approximately 6.2 Hz",
        "Section 3",
    ),
    "reaches constant": Quote(
        "manages to overcome it and reaches the value of the angular velocity constant", "Section 3"
    ),
    # conditions, slips and opinions: not judged
    "validity": Quote(
        "it is not valid when the absolute position of block 1 is greater than the absolute position of "
        "block 2",
        "Section 2.1",
    ),
    "smaller": Quote(
        "relative displacement between the blocks is smaller than this gap, impact occurs",
        "Section 2.1",
    ),
    "greater": Quote(
        "when the relative displacement between the blocks is greater than the gap", "Section 2.1"
    ),
    "two regions": Quote("the system is piecewise linear, consisting of two regions", "Section 2.1"),
    "complete": Quote(
        "more realistic, complete and complex than the model with the ideal excitation", "Abstract"
    ),
    "importance": Quote("the importance of using the non-ideal excitation source", "Section 4"),
    "helped": Quote(
        "A relationship between the forces provided by each source was defined which helped the comparison "
        "to be more realistic",
        "Section 4",
    ),
}


def said(*keys: str) -> tuple[Quote, ...]:
    """The quotes of these keys."""
    return tuple(QUOTES[key] for key in keys)
