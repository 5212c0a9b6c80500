"""A part of a tool path keeps all columns, and `inspect` fits parts of real programs near the ends of travel."""

from __future__ import annotations

import dataclasses

import numpy as np

import toolpace as tp
from toolpace.jobs.inspection import follow_as_planned

MACHINE = tp.Machine.load("xyzac-trunnion")
ARCS = "G21 G90 G94 G17 F2000\nG0 X0 Y0 Z0\n" + "G2 X496 Y0 I248 J0\nG2 X0 Y0 I-248 J0\n" * 2 + "M2\n"
"""Arcs to 4 mm from the end of the travel of X."""


def test_all_columns_of_a_part_are_those_of_its_points():
    whole = tp.read_text(ARCS, MACHINE, controller="linuxcnc")
    assert whole.bow.max() > 0.0
    first, last = len(whole) // 3, len(whole) // 2
    part = whole.part(first, last)
    assert len(part) == last - first + 1
    for column in dataclasses.fields(whole):
        value = getattr(whole, column.name)
        if isinstance(value, np.ndarray) and len(value) == len(whole) and column.name != "stop":
            np.testing.assert_array_equal(getattr(part, column.name), value[first : last + 1], err_msg=column.name)
    assert part.stop[[0, -1]].all() and not part.stop[1:-1].any()


def test_a_program_of_arcs_near_the_end_of_travel_is_followed():
    follow_as_planned(MACHINE, tp.read_text(ARCS, MACHINE, controller="linuxcnc"))
