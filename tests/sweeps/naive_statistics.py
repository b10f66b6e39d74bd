"""The statistics of a point in the plainest way: a densely sampled run, Python loops, no interpolation."""

import itertools
import math
from dataclasses import replace

import numpy as np

from tests.trajectories import opened
from vibsim.physics.parts import EVENT_KINDS


def dense_run(scene, per_second):
    """The whole run with so many samples per second, and its section."""
    trajectory = opened(replace(scene, every_num=1, every_den=per_second), section=True)
    blocks = list(trajectory.blocks())
    section = {name: np.concatenate([block.section[name] for block in blocks]) for name in blocks[0].section}
    samples = {name: np.concatenate([block.samples[name] for block in blocks]) for name in blocks[0].samples}
    events = {name: np.concatenate([block.events[name] for block in blocks]) for name in blocks[0].events}
    return samples, events, section


def naive_statistics(scene, begin, per_second=10_000):
    """Statistics by name, from sample values alone."""
    samples, events, section = dense_run(scene, per_second)
    marks = [t for t in section["time"].tolist() if t >= begin]
    rows = {name: np.concatenate([section[name], samples[name]]) for name in section}  # in no order
    quantities = {"x1": rows["x1"]}
    if scene.has_block2:
        quantities |= {"x2": rows["x2"], "relative": rows["x1"] - rows["x2"]}
    found = {"periods": len(marks) - 1}
    for name, values in quantities.items():
        halves = []
        for start, end in itertools.pairwise(marks):
            inside = values[(rows["time"] >= start) & (rows["time"] <= end)]
            halves.append((inside.max() - inside.min()) / 2)
        found[f"amplitude_{name}"] = sum(halves) / len(halves)
        found[f"amplitude_{name}_max"] = max(halves)
    late = rows["time"] >= begin
    last = list(quantities.values())[-1][late]
    found |= {"relative_min": last.min(), "relative_max": last.max()}
    for kind, name in (("contact_begin", "impacts_per_period"), ("stick_begin", "sticks_per_period")):
        times = events["t"][events["kind"] == EVENT_KINDS[kind]]
        found[name] = sum(marks[0] <= t < marks[-1] for t in times.tolist()) / found["periods"]
    if scene.has_block2:
        points = [(t, x) for t, x in zip(section["time"], section["x2"], strict=True) if t >= begin]
        found["drift_rate"] = np.polynomial.Polynomial.fit(*zip(*points, strict=True), 1).convert().coef[1]
    if scene.has_motor:
        speed = rows["phidot"][late] / (2 * math.pi)
        found |= {"min_speed": speed.min(), "max_speed": speed.max()}
        found["mean_speed"] = found["periods"] / (marks[-1] - marks[0])
    return found
