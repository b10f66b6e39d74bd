"""A table of numbers as the audit reads it, typed by hand: near what is measured, and small."""

from copy import deepcopy

from vibsim.evidence.reports.readings import POINTS, STATEMENTS

LETTERS = "ABC"
FORCE = {"A": 1.596, "B": 3.941, "C": 5.504}  # N, m3 e omega^2
PRINTED = {"A": 0.0725, "B": 0.1140, "C": 0.1350}
M3_E_OMEGA = {"A": 0.0726, "B": 0.1140, "C": 0.1348}
HERTZ = {"A": 3.5, "B": 5.5, "C": 6.5}
IDEAL, MOTORS = ("I-A", "I-B", "I-C"), ("II-A", "II-B", "II-C")
EQUAL = tuple(f"{name}-eq211" for name in IDEAL)
HALF = {"name": "half bilinear", "hz": 3.68}


def drift(rate, half_width=1e-6):
    way = "none" if abs(rate) <= half_width else "forward" if rate > 0 else "backward"
    return {"verdict": way, "rate": rate, "half_width": half_width}


def regime(verdict="periodic", period=1, end=300.0):
    return {
        "verdict": verdict,
        "period": period,
        "reason": "because",
        "span": {"begin": end / 2, "end": end},
        "exponent": {"value": -0.1, "half_width": 0.01},
    }


def nearby(law, c, hz, kind, later=None, period=None, at_rest=None):
    """A point of which most starts, and rest unless told otherwise, have a regime."""
    one = {"regime": kind, "period": period}
    row = {"law": law, "c": c, "hz": hz, **one, "starts": [{**one, "regime": at_rest or kind}, *4 * [one]]}
    return {**row, "later": later} if later else row


def cycles(verdict="every cycle", counts=None):
    return {
        "verdict": verdict,
        "reason": "impacts in 9 of 9 cycles",
        "impacts": 1.0,
        "impact_counts": counts or {"1": 9},
    }


def run(rate=0.0, vibration=0.01, **more):
    return {
        "overall": rate,
        "t_end": 300.0,
        "trust_horizon": 300.0,
        "impacts": 1000,
        "sticks": 1,
        "rest_distance_needed": 0.01,
        "steady": {"relative": vibration, "v1": 10 * vibration, "v2": vibration},
        "drift": drift(rate),
        "cycles": cycles(),
        "frequencies": {"lines": [{"hz": 6.5, "amplitude": vibration}]},
        "peak": {"time": 65.0, "height": 0.02, "end": -0.04},
        "regime": regime(),
        "changes": {},
        "how": "",
        **more,
    }


def capture(verdict="passed", since=None, until=None, speed=None, final=5.43, no_load=5.5):
    return {
        "verdict": verdict,
        "since": since,
        "until": until,
        "speed_hz": speed,
        "final_speed_hz": final,
        "no_load_speed_hz": no_load,
        "resonance": HALF if speed else None,
    }


def held(speed, last=0.18, before=0.16):
    return {"lines": [{"hz": 2 * speed, "amplitude": 0.08}], "reach": {"last": last, "before": before}}


def outcome(verdict="passed", since=None, until=None, speed=None, final=5.43, rate=0.0, peak=65.0):
    return {
        **motion(rate),
        "verdict": verdict,
        "since": since,
        "until": until,
        "speed_hz": speed,
        "final_hz": final,
        "peak": {"time": peak, "height": 0.08, "end": 0.05},
    }


def motion(rate=0.0, impacts=1000, vibration=0.01, kind="periodic", period=1, single=False):
    return {
        "drift": rate,
        "overall": rate,
        "impacts": impacts,
        "cycles": "every cycle",
        "one_per_cycle": single,
        "steady": {"relative": vibration, "v1": 10 * vibration, "v2": vibration},
        "regime": kind,
        "period": period,
    }


PASSED = outcome()
CAPTURED = outcome("captured", 14.0, None, 3.64, 3.64, rate=1e-4)
ESCAPED = outcome("escaped", 13.0, 134.0, 3.64, 6.17, rate=-2e-4, peak=170.0)
CHANGES = {"c": ["0.0035 N s/m", "0.001 N s/m"], "J": ["0.0085 kg m^2", "0.001 kg m^2"]}


def numbers():
    """The table: printed parameters do not capture, the readings do."""
    return deepcopy({
        "facts": {
            "held_hz": 4.130,
            "free_hz_I": 4.334,
            "free_hz_II": 4.149,
            "bilinear_hz_I": 7.70,
            "bilinear_hz_II": 7.37,
            "least_hold_s": {"0.001": 13.2, "0.01": 100.0},
            "amplitudes": [
                {
                    "omega_hz": HERTZ[x],
                    "printed": PRINTED[x],
                    "eq211": FORCE[x],
                    "m3_e_omega": M3_E_OMEGA[x],
                }
                for x in LETTERS
            ],
            "characteristics": [
                {"no_load_hz": HERTZ[x], "M0": 0.005, "slope": 0.005 / (6.2832 * HERTZ[x])} for x in LETTERS
            ],
        },
        "ends": {
            "as printed": end(4.0513, 3.709, 0.42e-3, "fold"),
            "c alone": end(4.2498, 3.707, 0.64e-3, "fold"),
            "J alone": end(4.5453, 3.681, 0.95e-3, "fold"),
            "the reading": end(5.5029, 3.678, 1.66e-3, "neimark-sacker"),
        },
        "runs": runs(),
        "long_runs": {name: {"regime": regime(end=3000.0)} for name in runs()},
        "ensembles": ensembles(),
        "without_stop": {name: without_stop(name) for name in (*IDEAL, *EQUAL, *MOTORS)},
        "nearby": [
            nearby("Table 1", 0.001, 3.5, "periodic", period=5),
            nearby("Table 1", 0.001, 3.8, "chaotic", {"regime": "chaotic", "period": None}),
            nearby("Eq. (2.11)", 0.0, 6.3, "quasi-periodic", {"regime": "periodic", "period": 10}),
        ],
        "gaps": [gap(1.0, 3.69, 1.3), gap(200.0, 3.9, 1.0), gap(252.0, 4.02, 0.0), gap(400.0, 4.04, 0.0)],
        "voltages": {name: {"outcomes": 47 * [CAPTURED] + [PASSED]} for name in ("II-B", "II-C")},
        "search": {
            "readings": {
                "ranking": [
                    reading({"excitation.J": "0.0085 kg m^2", "coupling.c": "0.0035 N s/m"}, 25, 0.3),
                    reading({"coupling.c": "0.03 N s/m"}, 25, 0.6),
                    reading({"stop.G": "1000 m"}, 25, 1.05, 4.02),
                    reading({}, 0, 0.65),
                    reading({"excitation.m3": "54 g"}, 3, 0.9),
                ]
            },
            "plane": {"ranking": plane()},
        },
        "solvers": [
            {"solver": "coarse", "II-B": {**CAPTURED, "drifted": 0.3}, "II-C": {**PASSED, "drifted": 0.1}},
            {"solver": "broken", "II-B": {"failed": "no longer finite"}, "II-C": {"failed": "why"}},
        ],
    })  # fmt: skip


def end(no_load, speed, torque, kind):
    """Where held orbits end: speeds [Hz], torque [N m]."""
    point = {"no_load_hz": no_load, "speed_hz": speed, "torque": torque, "power": 6.2832 * speed * torque}
    half = {**point, "no_load_hz": 0.9 * no_load, "speed_hz": 0.98 * speed, "power": point["power"] / 2.1}
    return {**point, "kind": kind, "amplitude": 0.05, "half": {**half, "amplitude": 0.034}}


def gap(gap_mm, speed, impacts):
    """What II-B does with a gap."""
    return {**outcome("captured", 20.0, None, speed, speed), "gap_mm": gap_mm, "impacts_per_turn": impacts}


def ensembles():
    """Perturbed starts by case."""
    ideal = {
        "I-A": [motion(1.7e-5, 600, 0.001, period=5)] * 4,
        "I-B": [motion(7e-5, 1466, 0.003, period=period) for period in (1, 6, 6, 18)],
        "I-C": [motion(2.9e-4, 1950, 0.004, "transient", single=True)] * 4,
        "I-A-eq211": [motion(3e-4, 2100, 0.018)] * 4,
        "I-B-eq211": [motion(1e-3, 2000, 0.036, "chaotic", None)] * 4,
        "I-C-eq211": [motion(2.5e-3, 2200, 0.070, "chaotic", None)] * 4,
    }
    motors = {
        "II-A": [{**outcome("not met", final=3.48, rate=8e-5), "impacts": 2056}] * 4,
        "II-B": [_lingering(rate, "undecided") for rate in (1e-3, -1e-5, 2e-4, 3e-5)],
        "II-C": [_lingering(rate, "periodic", 8) for rate in (-3e-4, 8e-4, 1e-4, -1e-3)],
        "II-B-captured": 11 * [CAPTURED] + [PASSED],
        "II-C-escape": 11 * [ESCAPED] + [PASSED],
    }
    return {name: {"outcomes": outcomes} for name, outcomes in {**ideal, **motors}.items()}


def _lingering(rate, kind, period=None):
    late = 6.3 if period else 5.43
    return {
        **outcome("passed", 11.0, 23.0, 3.69, late, rate),
        "impacts": 2100,
        "regime": kind,
        "period": period,
        "steady": {"relative": 0.03, "v1": 0.3, "v2": 0.03},
    }


def without_stop(name):
    """A case without its stop: still, periodic; with equal forces thrown further by the start."""
    return {
        "drift": drift(0.0),
        "overall": 5e-3 if name in EQUAL else 1e-6,
        "impacts": 0,
        "starts_overall": 1e-6,
        "starts_drifting": 0,
        "regime": regime(end=10000.0),
        "capture": capture("captured", 10.0, None, 4.02, 4.02) if name in MOTORS else None,
    }


def runs():
    """The runs by name."""
    return {
        "I-A": run(1.7e-5, 0.001, impacts=630, regime=regime("periodic", 5)),
        "I-B": run(-7.6e-5, 0.003, impacts=1466, regime=regime("periodic", 18)),
        "I-C": run(-2.9e-4, 0.004, impacts=1948, regime=regime("transient", 1)),
        "I-A-eq211": run(3e-4, 0.018, drift=drift(-1e-4, 2e-4)),
        "I-B-eq211": run(1e-3, 0.036, drift=drift(-1e-4, 7e-4), regime=regime("chaotic", None)),
        "I-C-eq211": run(2.5e-3, 0.070, drift=drift(1e-4, 1e-4), trust_horizon=40.0),
        "II-A": run(-8e-5, 0.008, capture=capture("not met", final=3.48, no_load=3.5)),
        "II-B": run(2.2e-3, 0.026, capture=capture(since=10.9, until=23.1, speed=3.69), held=held(3.69),
                    trust_horizon=80.0, rest_distance_needed=0.0703),
        "II-C": run(-3e-4, 0.037, capture=capture(final=6.38, no_load=6.5), trust_horizon=85.0),
        "II-B-captured": run(1e-4, 0.17, capture=capture("captured", 13.9, None, 3.64, 3.64),
                             held=held(3.64), changes=CHANGES),
        "II-C-escape": run(-2e-4, 0.09, capture=capture("escaped", 12.7, 134.2, 3.64, 6.17, 6.5),
                           held=held(3.64), changes=CHANGES, trust_horizon=138.0,
                           peak={"time": 168.0, "height": 0.083, "end": 0.057}),
    }  # fmt: skip


def reading(changes, count, price, held_at=3.67):
    """A reading that II-B is captured under from so many of 25 starts, and nothing else is true of."""
    medians = [4.0, 40.0, 100.0, 6.2, 160.0, 0.2, held_at]
    counts = [count, *[0] * (len(STATEMENTS) - 1)]
    return {
        "changes": changes,
        "price": price,
        "leaving": 0.6 if changes == {"stop.G": "1000 m"} else 0.1 * len(changes),
        "explained": int(count >= 20),
        "statements": [
            {"text": said.text, "holds": number >= 20, "count": number, "of": 25, "median": median}
            for said, number, median in zip(STATEMENTS, counts, medians, strict=True)
        ],
    }


def plane():
    """Points over J and c; II-B is captured where J is large."""
    places = [(0.5 + 19.5 * i / POINTS, 0.001 * (1 + i % 7)) for i in range(POINTS)]
    return [
        reading({"excitation.J": f"{J} g m^2", "coupling.c": f"{c} N s/m"}, 25 if J > 5 else 0, 0.5)
        for J, c in places
    ] + [reading({}, 0, 0.6)]
