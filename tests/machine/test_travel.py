"""Travel is kept to the nanometre, at both ends, by every joint, and the worst of all is named."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.common.errors import ReachError
from toolpace.machine.machine import Machine

MACHINE = Machine.load("xyzac-trunnion")
BLOCK = np.array([3, 5, 7])


def positions(joint, value):
    q = np.zeros((3, 5))
    q[1, joint] = value
    return q


@pytest.mark.parametrize("joint", [0, 1, 2, 3])
@pytest.mark.parametrize("end", [0, 1])
def test_a_joint_may_go_to_its_end_and_a_nanometre_for_rounding(joint, end):
    limit, out = MACHINE.travel[joint, end], (-1.0, 1.0)[end]
    for beyond in (0.0, 0.9e-9):
        MACHINE.check_travel(positions(joint, limit + out * beyond), BLOCK, "part.ngc")
    for beyond in (1.1e-9, 1e-6, 0.9e-3, 1.0):
        word = "above" if end else "below"
        with pytest.raises(ReachError, match=rf"part\.ngc:5: joint {MACHINE.joints[joint]} .*{word} its limit of"):
            MACHINE.check_travel(positions(joint, limit + out * beyond), BLOCK, "part.ngc")


def test_an_endless_joint_has_no_end():
    MACHINE.check_travel(positions(4, 1e4), BLOCK)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_position_is_refused_with_its_line(value):
    with pytest.raises(ReachError, match=r"part\.ngc:5: joint positions are not finite"):
        MACHINE.check_travel(positions(4, value), BLOCK, "part.ngc")


def test_the_worst_joint_is_named_with_figures_and_the_other_lines():
    q = np.zeros((3, 5))
    q[0, 0], q[1, 0], q[2, 1] = 0.501, 0.6, -0.51
    with pytest.raises(ReachError, match=r":5: joint X would have to go to 600\.000 mm, above its limit of 500") as e:
        MACHINE.check_travel(q, BLOCK, "part.ngc")
    assert "3" in str(e.value) and "7" in str(e.value)
    q = np.zeros((3, 5))
    q[0, 3], q[1, 0] = math.radians(-140.0), 0.501
    with pytest.raises(ReachError, match=r":3: joint A would have to go to -140\.000 deg, below its limit of -130 deg"):
        MACHINE.check_travel(q, BLOCK, "part.ngc")


@pytest.mark.parametrize("span, units", [(1.1, False), (2.9, False), (3.1, True), (300.0, True)])
def test_where_more_than_the_whole_travel_is_asked_for_no_moving_of_the_part_is_proposed(span, units):
    there = float(np.ptp(MACHINE.travel[0]))
    q = np.zeros((3, 5))
    q[2, 0] = span * there
    with pytest.raises(
        ReachError, match=f"the program uses {span * there * 1e3:.0f} mm of X, which has 1000 mm; "
    ) as e:
        MACHINE.check_travel(q, BLOCK, "part.ngc")
    assert ("inches" in str(e.value)) == units
    assert str(e.value).endswith("take a larger machine") and "move the part" not in str(e.value)


def test_where_the_travel_would_do_moving_the_part_is_proposed():
    q = np.zeros((3, 5))
    q[2, 0] = 0.99 * float(np.ptp(MACHINE.travel[0]))
    with pytest.raises(ReachError, match="move the part"):
        MACHINE.check_travel(q, BLOCK, "part.ngc")
