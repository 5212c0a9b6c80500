"""ruckig: state to state within velocity, acceleration and jerk; along a path it must stop at every way point.

Its open version knows no way points without stopping, so the path is cut into straight joint moves that keep within
`DEVIATION` of it (in shares of the joints' ranges), each from rest to rest and synchronised in phase.
"""

from __future__ import annotations

import numpy as np
import ruckig

from benchmarks.peers import Outcome, Stopwatch, failed
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath

DEVIATION = 1e-3
UNLIMITED = 1e6


def solve(axis_path: AxisPath, limits: Limits, n: int) -> Outcome:
    """Stop and go over the fewest even pieces (at most n) that keep to the path."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    dense = run.evaluate(np.linspace(run.s0, run.s1, n * 4 + 1))[0]
    span = np.ptp(dense, axis=0).max()
    pieces = 8
    while pieces < n and deviation(dense, pieces) > DEVIATION * span:
        pieces *= 2
    pieces = min(pieces, n)
    points = run.evaluate(np.linspace(run.s0, run.s1, pieces + 1))[0]
    m = len(limits)
    otg, given, answer = ruckig.Ruckig(m), ruckig.InputParameter(m), ruckig.Trajectory(m)
    given.synchronization = ruckig.Synchronization.Phase
    velocity = np.minimum(limits.velocity, UNLIMITED)
    given.max_acceleration = limits.acceleration.tolist()
    given.max_jerk = limits.jerk.tolist()
    duration = 0.0
    s = np.linspace(run.s0, run.s1, pieces + 1)
    cap = run.speed_cap((s[1:] + s[:-1]) / 2.0)
    for a, b, rate in zip(points[:-1], points[1:], cap / np.diff(s)):
        # the feed, as a cap on every joint of a move that is straight in the joints
        share = np.maximum(np.abs(b - a), 1e-12)
        given.max_velocity = np.minimum(velocity, rate * share).tolist()
        given.current_position, given.target_position = a.tolist(), b.tolist()
        if otg.calculate(given, answer) not in (ruckig.Result.Working, ruckig.Result.Finished):
            return failed(watch(), "no motion found")
        duration += answer.duration
    return Outcome(duration, watch(), note=f"{pieces} stops", points=pieces + 1)


def deviation(dense: np.ndarray, pieces: int) -> float:
    """Largest distance of a joint from the chords over even pieces."""
    x = np.linspace(0.0, 1.0, len(dense))
    knots = np.linspace(0.0, 1.0, pieces + 1)
    worst = 0.0
    for joint in dense.T:
        chord = np.interp(x, knots, np.interp(knots, x, joint))
        worst = max(worst, float(np.abs(chord - joint).max()))
    return worst
