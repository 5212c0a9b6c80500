"""Lines and arcs under offsets and turns: our reading beside a second one, from LinuxCNC's manual, to all digits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from testbed.against_rs274 import read_job
from testbed.linuxcnc.by_manual import by_manual
from testbed.linuxcnc.job import Job
from testbed.linuxcnc.places import places_job
from testbed.linuxcnc.walk import Walk
from toolpace.common.errors import ToolpaceError

HEAD = "G21 G90 G94 G17 G91.1 F600\n"
MEANT = ("there is no motion", "a full circle, or none")


def different(seeds: range) -> list[str]:
    found = []
    for seed in seeds:
        job = places_job(seed)
        theirs = by_manual(job)
        try:
            what = Walk(read_job(job), theirs, numbered=False).difference() or theirs.error
        except ToolpaceError as error:
            what = "" if theirs.error or any(said in str(error) for said in MEANT) else str(error)
        if what:
            found.append(f"seed {seed}: {what}")
    return found


@pytest.mark.sweep
def test_eighty_programs():
    assert not different(range(80))


@pytest.mark.thorough
def test_two_thousand_programs():
    assert not different(range(80, 2080))


def only(text: str, **tables) -> tuple[np.ndarray, float]:
    """End (6,) [mm, deg] and angle [deg] of the last motion that the second reading tells."""
    last = by_manual(Job(HEAD + text, **tables)).motions[-1]
    return last.end, math.degrees(last.sweep)


@pytest.mark.parametrize(
    ("text", "sweep"),
    [
        ("G0 X10 Y0\nG2 X10.005 Y0 I-10 J0", -360), ("G0 X10 Y0\nG2 I-10 P2", -720), ("G0 X10 Y0\nG3 X0 Y10 I-10", 90),
        ("G0 X10 Y0\nG3 X10 Y0.0001 I-10", math.degrees(1e-5)),
        ("G0 X10 Y0\nG3 X10 Y-0.0001 I-10", 360 - math.degrees(1e-5)),
        ("G18 G0 Z10 X0\nG2 X10 Z0 K-10", -270), ("G0 X5\nG3 X-5 R5", 180), ("G0 X3\nG2 X0 Y3 R-3", -270),
        ("G0 X3\nG2 X0 Y3 R3", -90),
    ],
)  # fmt: skip
def test_angles_of_the_second_reading(text, sweep):
    assert only(text)[1] == pytest.approx(sweep, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "end"),
    [
        # words (1, 2), turned by 90 degrees, from an origin at (10, 20)
        ("G10 L2 P1 X10 Y20 R90\nG1 X1 Y2", (8, 21, 0)),
        # the place at hand, (5, 0), is X1: X3 is 7
        ("G0 X5\nG92 X1\nG1 X3", (7, 0, 0)),
        # G92 acts within the turn: at (5, 0) the words are (0, -5), and become (0, 0)
        ("G10 L2 P1 R90\nG0 X0 Y-5\nG92 Y0\nG1 Y1", (4, 0, 0)),
        ("G0 X5\nG10 L20 P1 X2\nG1 X3", (6, 0, 0)),
        ("G43 H1\nG1 Z1", (0, 0, 51)),
        ("G43.1 X2 Z3\nG1 X1 Z1", (3, 0, 4)),
        ("G20\nG1 X1", (25.4, 0, 0)),
        ("G54\nG0 X1\nG53 G1 X2", (2, 0, 0)),
    ],
)  # fmt: skip
def test_places_of_the_second_reading(text, end):
    assert only(text, tools={1: 50.0})[0][:3] == pytest.approx(end, abs=1e-12)


@pytest.mark.parametrize(("off", "refused"), [(0.0282, False), (0.0284, True)])
def test_radii_of_the_second_reading(off, refused):
    assert bool(by_manual(Job(f"{HEAD}G0 X1\nG3 X0 Y{1 + off} I-1\n")).error) == refused


@pytest.mark.parametrize("text", ["G2 X10 Y0 I-10", "G2 X10.01 Y0 I-10", "G3 X10 Y0.0001 I-10 P2"])
def test_a_whole_turn_more_or_less_is_noticed(text):
    """The comparison itself: our reading of the arc without its whole turn, and with one too many."""
    job = Job(f"{HEAD}G0 X10 Y0\n{text}\nG1 X20\nM2\n", numbered=False)
    turns = 2 if "P2" in text else 1
    for other in {turns + 1, 3 - turns}:
        wrong = Job(job.text.replace(text, f"{text.removesuffix(' P2')} P{other}"), numbered=False)
        assert Walk(read_job(wrong), by_manual(job), numbered=False).difference()
    nothing = Job(job.text.replace(text, "G1 X10.005"), numbered=False)
    assert Walk(read_job(nothing), by_manual(job), numbered=False).difference()
