"""A virtual control that is driven by hand, and the joints that come of it."""

from __future__ import annotations

import math

from toolpace.programs.reading.control.control import Control
from toolpace.programs.reading.control.state import Rules
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

MM, DEG = 1e-3, math.pi / 180.0
ALL = 7
"""Bits of X, Y and Z."""


def control(machine, setup=None, **rules):
    options = ReadOptions(setup=setup or SetUp())
    controller = Controller.load("linuxcnc")
    made = Control(Source.from_text("G0\n" * 50), machine, controller, options, Findings(), Rules(**rules))
    made.feed.set(1000.0, MM, 1)
    made.begin_block(1)
    return made


def place(x, y, z, *turned):
    return [x * MM, y * MM, z * MM, *(angle * DEG for angle in turned)]


def turned(made, x, y, z, **angles):
    """Words with rotary axes by letter [deg]; those that are not named are zero."""
    words = place(x, y, z) + [0.0] * (len(made.words) - 3)
    for letter, angle in angles.items():
        words[made.slot(letter)] = angle * DEG
    return words


def joints(made, machine):
    """Joint positions at the points of the path."""
    path = made.toolpath()
    return machine.joints_at(path.tip, path.rotary, path.tool_length)


def go(made, *places):
    for k, each in enumerate(places):
        made.begin_block(k + 1)
        made.straight(each, ALL, rapid=True)
