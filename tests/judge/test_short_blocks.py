"""From which length on the judge tells that a block is passed faster than its feed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import toolpace as tp

MACHINE = tp.Machine.load("xyzac-trunnion")
STEP, TIP = 1e-3, 1e-5
FAST = 0.02
"""Of the motion, and of the blocks beside [m/s]."""


def program(length: float, feed: float) -> tp.ToolPath:
    """A line of 40 mm with a block of a length [mm] and a feed [mm/min] in its middle."""
    return tp.read_text(
        f"G21 G90 G94\nG0 X0 Y0 Z50\nG1 X20 F1200\nX{20 + length:.4f} F{feed}\nX40 F1200\nM2\n", MACHINE
    )


@cache
def motion() -> tp.Trajectory:
    """All of it at 20 mm/s."""
    return tp.plan(tp.Path.fit(program(1.0, 1200), TIP, machine=MACHINE), MACHINE, bound=False)


def feed_check(length: float, shift: float = 0.0) -> tp.Check:
    """What the judge says of that motion for the program whose block is at half the feed, and begins elsewhere [mm]."""
    points = motion().sample(STEP)
    slow = program(length, 600)
    tip = slow.tip.copy()
    tip[1:-1, 0] += 1e-3 * shift
    found = tp.verify(points, MACHINE, tp.ToolPath(**{**vars(slow), "tip": tip}), TIP)
    return next(check for check in found.checks if check.what == "feed")


@pytest.mark.parametrize("shift", np.linspace(0.0, 0.018, 4))
def test_a_block_longer_than_two_tolerances_and_two_steps_is_seen_at_any_phase(shift: float) -> None:
    check = feed_check(1e3 * (2.0 * TIP + 2.0 * FAST * STEP) * 1.01, shift)
    assert not check.ok and check.value / check.limit == pytest.approx(2.0, rel=1e-3)
    assert check.note == ""


@pytest.mark.parametrize("shift", [0.0, 0.007])
def test_one_no_longer_than_two_tolerances_is_not_and_that_is_said(shift: float) -> None:
    check = feed_check(1e3 * 2.0 * TIP * 0.99, shift)
    assert check.ok and check.note == "not told of 1 block within the tolerance of a faster one"


def test_a_motion_that_keeps_the_feed_of_a_short_block_is_told_so_too() -> None:
    slow = program(0.02, 600)
    planned = tp.plan(tp.Path.fit(slow, TIP, machine=MACHINE), MACHINE, bound=False)
    check = next(each for each in tp.verify(planned, MACHINE, slow, TIP).checks if each.what == "feed")
    assert check.ok and "not told of 1 block" in check.note


def test_a_narrower_tolerance_tells_it() -> None:
    slow, points = program(0.05, 600), motion().sample(STEP)
    assert next(each for each in tp.verify(points, MACHINE, slow, TIP).checks if each.what == "feed").note == ""
    assert not tp.verify(points, MACHINE, slow, 2e-6).ok
