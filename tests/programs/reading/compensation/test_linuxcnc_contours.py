"""Cutter compensation of LinuxCNC, against its own interpreter (`rs274`) on random contours, and case by case.

More by `python -m testbed.against_rs274 --contours --programs N`.
"""

from __future__ import annotations

import pytest

from testbed.against_rs274 import Job, difference, surprise
from testbed.linuxcnc.contours import random_contour
from testbed.linuxcnc.rs274 import available, judged

pytestmark = [
    pytest.mark.linuxcnc,
    pytest.mark.skipif(available() is None, reason="rs274 is not installed (linuxcnc-uspace)"),
]
HEAD = "G21 G90 G94 G17 F600\nT1 M6\nG0 X-20 Y-20 Z0\n"
TABLES = {"tools": {1: 50.0, 2: 30.0}, "radii": {1: 4.0, 2: 2.5}}


def different(seeds: range) -> list[str]:
    found = ((seed, surprise(random_contour(seed))) for seed in seeds)
    return [f"seed {seed}: {what}" for seed, what in found if what]


def test_eight_random_contours():
    assert not different(range(8))


@pytest.mark.sweep
def test_a_hundred_random_contours():
    assert not different(range(8, 108))


@pytest.mark.thorough
def test_two_thousand_random_contours():
    assert not different(range(108, 2108))


@pytest.mark.parametrize(
    "contour",
    [
        "G41 G1 X0 Y0\nY50\nX50\nX80 Y20\nX-30\nG40 X-30 Y-40\n",
        "G41 G1 X0 Y0\nX50\nX20 Y30\nG40 X25 Y12\n",
        "G42.1 D7 G1 X0 Y0\nX30\nG2 X40 Y10 I10 J0\nG1 X60\nG40 X80 Y30\n",
        "G42 D2\nG2 X10 Y-30 R25\nG1 X40\nG3 X40 Y0 R15\nG40\nG0 Z20\n",
        "G41 G1 X0 Y0\nX30\nG0 Z5\nX60\nZ-2\nG1 Y30\nG40 X90\n",
        "G41 G1 X0 Y0\nX30\nG0 X60 Y-9\nG1 Y30 A20\nG40 X90\n",
        "G41 G1 X0 Y0\nG3 I0 J30\nG1 X-20 Y0\nG40 Y-30\n",
        "G93\nG42 D2 G1 X0 Y0 F12\nX30 F8\nG2 X40 Y10 I10 J0 F9\nG40 G1 X80 Y30 F7\n",
        "G91\nG41 D2 G1 X20 Y20\nX30\nY9\nG40 X20\n", "G41 D0 G1 X0 Y0\nX30\nG40\nX50\n",
        "G18\nG41 D2 G1 X0 Z10\nX30\nG3 X40 Z20 I0 K10\nG1 Z60\nG40 X80\n",
        "G42.1 D-7 G1 X0 Y0\nX30\nY30\nG40 X80\n",
    ],
)  # fmt: skip
def test_the_same_way(contour):
    """Both run it, and go the same way."""
    job = Job(f"{HEAD}{contour}M2\n", **TABLES)
    diameters = {1: 8.0 / 25.4, 2: 5.0 / 25.4}
    assert judged(job.text, job.parameters(), {1: 50.0 / 25.4, 2: 30.0 / 25.4}, diameters).error == ""
    assert difference(job) == ""


@pytest.mark.parametrize("block", ["G53 G0 X1", "G55", "G2 X9 Y1 R5", "G1 Y2 Z-1", "G18", "M6 T1", "G81 Z-1 R1"])
def test_without_a_radius_the_contour_is_the_way(block):
    """No tool: both run, or refuse, what a compensation without a radius forbids."""
    assert difference(Job(f"G21 G90 G94 G17 F600\nG0 X1 Y1 Z3\nG41\nG1 X5\n{block}\nG40 G1 X9\nM2\n", **TABLES)) == ""


@pytest.mark.parametrize(
    "block",
    [
        "G55", "G92 X1", "G52 X1", "G61", "G64 P.1", "G43 H1", "G49", "T2 M6", "G28", "G30", "G53 G0 Z1", "G98",
        "G81 X1 Y1 Z-2 R1", "G41 D2", "G42", "G10 L2 P1 X1", "M48", "M53 P1", "M64 P1", "G18", "G19", "#1=#5420",
        "G5 X1 Y1 I1 J1 P1 Q1", "Y2\nX0", "G2 X61 Y-1 R1", "G40\nG2 X70 Y-10 R20", "G41.1 D4",
    ],
)  # fmt: skip
def test_both_refuse(block):
    """What stands within the contour is refused by us too; without it the program runs."""
    text = f"{HEAD}G41 G1 X0 Y0\nX60\n{{}}G40 X90\nM2\n"
    assert difference(Job(text.format(""), **TABLES)) == ""
    job = Job(text.format(block + "\n"), **TABLES)
    assert judged(job.text, job.parameters(), {1: 2.0, 2: 1.2}, {1: 8.0 / 25.4, 2: 5.0 / 25.4}).error
    assert difference(job) == ""
