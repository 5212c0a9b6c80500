"""A deflection that is measured itself does what the tip does that is as far from where it was commanded."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.follow import Follower, Measurement, Status
from toolpace.follow.figures import CAUSES

DELAY = 6e-3
PROGRAM = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z11 F900\nX13 Y-3 A2 C3 F500\nM2\n"


@pytest.fixture(scope="module")
def planned():
    """A short trajectory and the machine to follow it on."""
    machine = tp.Machine.load("linuxcnc-xyzac-trt")
    toolpath = tp.read_text(PROGRAM, machine, name="short.ngc")
    on = machine.reserved(0.1)
    return tp.plan(tp.Path.fit(toolpath, machine=on), on), machine


def bent(t: float) -> np.ndarray:
    """(3,) deflection at a time [m]."""
    return 1e-4 * np.array([np.sin(9.0 * t), np.cos(7.0 * t), 0.5 - np.sin(4.0 * t) ** 2])


@pytest.mark.parametrize("cause", CAUSES)
def test_it_is_the_tip_less_where_that_was_commanded(planned, cause):
    trajectory, machine = planned
    by_tip, by_itself = (
        Follower(trajectory, machine, cause=cause, delay=DELAY, gain=0.1, rho=0.2, deadband=2e-5) for _ in range(2)
    )
    given = [trajectory.at(np.zeros(1)).q[0]]
    jumped = False
    for k in range(400):
        t = k * 1e-3
        off = bent(t)
        commanded = machine.forward(given[max(k - 6, 0)][None])[0][0]
        one = by_tip.step(Measurement(t, tip=commanded + off))
        other = by_itself.step(Measurement(t, deflection=off))
        assert one.q == pytest.approx(other.q, abs=1e-11)
        assert one.status == other.status
        jumped |= bool(one.status & Status.JUMPED)
        given.append(one.q)
    assert jumped == (cause == "displaced")
    assert np.abs(one.correction[0]).max() > 2e-5


def test_what_is_no_figure_is_told(planned):
    follower = Follower(*planned)
    assert follower.step(Measurement(0.0, deflection=(np.nan, 0.0, 0.0))).status == Status.NOT_A_NUMBER
    assert follower.step(Measurement(1e-3, deflection=(1.0, 0.0, 0.0))).status == Status.ABSURD
