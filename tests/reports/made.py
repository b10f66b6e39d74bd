"""A table of numbers as the audit reads it, typed by hand: near what is measured, and small."""

from copy import deepcopy

from vibsim.reports.parameter_search import NO_CONTACT

LETTERS = "ABC"
FORCE = {"A": 1.596, "B": 3.941, "C": 5.504}  # N, m3 e omega^2
PRINTED = {"A": 0.0725, "B": 0.1140, "C": 0.1350}
M3_E_OMEGA = {"A": 0.0726, "B": 0.1140, "C": 0.1348}
HERTZ = {"A": 3.5, "B": 5.5, "C": 6.5}
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


def run(rate=0.0, vibration=0.01, **more):
    return {
        "t_end": 300.0,
        "trust_horizon": 300.0,
        "impacts": 1000,
        "sticks": 1,
        "rest_distance_needed": 0.01,
        "steady": {"relative": vibration, "v1": 10 * vibration, "v2": vibration},
        "drift": drift(rate),
        "cycles": {"verdict": "every cycle", "reason": "impacts in 9 of 9 cycles", "impacts": 1.0},
        "frequencies": {"lines": [{"hz": 6.5, "amplitude": vibration}]},
        "peak": {"time": 65.0, "height": 0.02, "end": -0.04},
        "regime": regime(),
        "changes": {},
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
        "verdict": verdict,
        "since": since,
        "until": until,
        "speed_hz": speed,
        "final_hz": final,
        "drift": rate,
        "peak": {"time": peak, "height": 0.08, "end": 0.05},
    }


PASSED = outcome()
CAPTURED = outcome("captured", 14.0, None, 3.64, 3.64, rate=1e-4)
ESCAPED = outcome("escaped", 13.0, 134.0, 3.64, 6.17, rate=-2e-4, peak=170.0)
CHANGES = {"c": ["0.00175 N s/m", "0.001 N s/m"], "m3": ["0.062 kg", "0.03 kg"]}


def numbers():
    """The table: printed parameters do not capture, the readings do."""
    return deepcopy({
        "facts": {
            "held_hz": 4.130,
            "free_hz_I": 4.334,
            "free_hz_II": 4.149,
            "bilinear_hz_I": 7.70,
            "bilinear_hz_II": 7.37,
            "amplitudes": [
                {
                    "omega_hz": HERTZ[x],
                    "printed": PRINTED[x],
                    "eq211": FORCE[x],
                    "m3_e_omega": M3_E_OMEGA[x],
                }
                for x in LETTERS
            ],
        },
        "runs": runs(),
        "long_runs": {name: {"regime": regime(end=3000.0)} for name in runs()},
        "ensembles": {
            "II-B": {"outcomes": [outcome(rate=rate) for rate in (1e-3, -1e-4, 2e-4, 3e-5)]},
            "II-C": {"outcomes": [outcome(rate=rate) for rate in (-3e-4, 8e-4, 1e-4, -1e-3)]},
            "II-B-captured": {"outcomes": 11 * [CAPTURED] + [PASSED]},
            "II-C-escape": {"outcomes": 11 * [ESCAPED] + [PASSED]},
        },
        "search": {
            "alone": [
                {"at": {"coupling.c": 0.03}, "II-B": CAPTURED, "II-C": PASSED},
                {"at": {"excitation.m3": 0.054}, "II-B": CAPTURED, "II-C": ESCAPED},
                {"at": {"stop.G": NO_CONTACT}, "II-B": CAPTURED, "II-C": CAPTURED},
                {"at": {"excitation.M0": 0.01}, "II-B": PASSED, "II-C": PASSED},
            ],
            "together": [],
        },
        "solvers": [
            {"solver": "coarse", "II-B": {**CAPTURED, "drifted": 0.3}, "II-C": {**PASSED, "drifted": 0.1}},
            {"solver": "broken", "II-B": {"failed": "no longer finite"}, "II-C": {"failed": "why"}},
        ],
    })  # fmt: skip


def runs():
    """The runs by name."""
    return {
        "I-A": run(1.7e-5, 0.001),
        "I-B": run(-7.6e-5, 0.003),
        "I-C": run(-2.9e-4, 0.004, regime=regime("transient", 1)),
        "I-A-eq211": run(-1e-4, 0.018, drift=drift(-1e-4, 2e-4)),
        "I-B-eq211": run(-1e-4, 0.036, drift=drift(-1e-4, 7e-4)),
        "I-C-eq211": run(1e-4, 0.070, drift=drift(1e-4, 1e-4), trust_horizon=40.0),
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
