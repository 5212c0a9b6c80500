"""What is granted for rounding of times, positions and derivatives: just inside it passes, just outside it is found.

Steps, times and positions are binary fractions wherever what is granted is near the rounding of a double: what is wrong
then is wrong by just the amount that is named.
"""

from __future__ import annotations

import copy

import numpy as np
import pytest

from tests.support import motions
from toolpace.judge import verify
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import SetPoints

POINTS = motions.set_points()
MACHINE = motions.machine()
NANO = [(3e-9, True), (0.5e-9, False)]
"""By how much something is wrong, and whether that is found."""
STEP = 2.0**-6
SLOW = Limits([10.0], [10.0], [1e-12], ("X",))
"""Of a joint whose jerk hides nothing in a step."""


def found(points, machine):
    return {check.name: check for check in verify(points, machine).findings}


def one_joint(t, q, qd, qdd, qddd):
    values = [np.broadcast_to(np.asarray(value, dtype=float), t.shape)[:, None].copy() for value in (q, qd, qdd, qddd)]
    return SetPoints(t, *values, np.zeros((0, 3)), np.zeros((0, 3)), np.ones(len(t), dtype=np.int64), ("X",))


@pytest.mark.parametrize(("far", "wrong"), NANO)
@pytest.mark.parametrize("end", ["lowest", "highest"])
@pytest.mark.parametrize("joint", ["Y", "C"])
def test_a_joint_may_be_a_nanometre_or_nanoradian_out_of_its_travel(joint, end, far, wrong):
    j, machine = MACHINE.joints.index(joint), copy.copy(MACHINE)
    travel = np.column_stack((np.full(len(MACHINE.joints), -np.inf), np.full(len(MACHINE.joints), np.inf)))
    travel[j] = (POINTS.q[:, j].min() + far, np.inf) if end == "lowest" else (-np.inf, POINTS.q[:, j].max() - far)
    object.__setattr__(machine, "travel", travel)
    name = f"{end} position of {joint}"
    assert [what for what in found(POINTS, machine) if "position" in what] == ([name] if wrong else [])


@pytest.mark.parametrize(("share", "wrong"), NANO)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_step_may_differ_by_a_billionth_of_itself(sign, share, wrong):
    """A time in the middle is early, or late; so the steps on both sides of it differ."""
    t = STEP * np.arange(40)
    t[20] += sign * share * STEP
    told = found(one_joint(t, 0.0, 0.0, 0.0, 0.0), SLOW)
    assert list(told) == (["unevenness of the time step"] if wrong else [])
    assert not wrong or told["unevenness of the time step"].time in t[19:21]


@pytest.mark.parametrize(("share", "wrong"), NANO)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("column", ["velocity", "acceleration"])
def test_a_column_may_be_off_by_a_billionth_of_itself(column, sign, share, wrong):
    """At a speed or an acceleration of 1 for a second: the column tells it too high, or too low."""
    t, told = STEP * np.arange(65), 1.0 + sign * share
    points = one_joint(t, t, told, 0.0, 0.0) if column == "velocity" else one_joint(t, t**2 / 2.0, t, told, 0.0)
    columns = [what for what in found(points, SLOW) if "column" in what]
    assert columns == ([f"{column} column of X"] if wrong else [])


@pytest.mark.parametrize(("share", "wrong"), NANO)
def test_a_jerk_may_be_what_a_billionth_of_the_acceleration_is_in_a_step(share, wrong):
    """An acceleration of 1, which that much could change from each step to the next, and a column that says so."""
    t = STEP * np.arange(257)
    points = one_joint(t, t**2 / 2.0, t, 1.0, share / STEP)
    columns = [what for what in found(points, SLOW) if "column" in what]
    assert columns == (["jerk column of X"] if wrong else [])
