"""A tool that was held goes on, wherever it stood, and however slow its machine is beside the path."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.deflection.following import Status

PERIOD = 0.01
PROGRAM = """G21 G90 G94
G0 X0 Y0 Z5 A0 C0
G1 Z0 F600
X20 F1200
Y15
X5 Y5 F300
G2 X-10 Y5 I-7.5 J0 F900
M2
"""


@pytest.fixture(scope="module")
def slow():
    """A plan at its limits nearly all along: it leaves a rising pace no room at the pace that it was made for."""
    machine = tp.Machine.load("xyzac-trunnion")
    machine = machine.with_limits(machine.limits.scaled(1e-2, 1e-3, 1e-4))
    path = tp.Path.fit(tp.read_text(PROGRAM, machine), tip_tolerance=20e-6, axis_tolerance=2e-3, machine=machine)
    return tp.plan(path, machine.reserved(0.1), bound=False), machine


@pytest.mark.parametrize("feed", [1.0, 1.2, 0.7])
@pytest.mark.parametrize("begin", [8.0, 12.0, 16.0, 20.0, 23.5])
def test_it_goes_on_to_the_end_within_its_limits(slow, begin: float, feed: float):
    trajectory, machine = slow
    follower = tp.Follower(trajectory, machine, period=PERIOD)
    q = [trajectory.at(0.0).q] * 3
    held = 0
    for k in range(int((2.0 * follower.duration / feed + 20.0) / PERIOD)):
        hold = k >= begin / PERIOD and held < 100
        point = follower.step(feed=0.0 if hold else feed)
        held += hold and bool(point.status & Status.HELD)
        q.append(point.q)
        if point.status & Status.ENDED:
            break
    assert held == 100 and point.status & Status.ENDED
    jerk = np.abs(np.diff(np.array(q), 3, axis=0)) / PERIOD**3
    assert (jerk / machine.limits.jerk).max() <= 1.0 + 1e-4
