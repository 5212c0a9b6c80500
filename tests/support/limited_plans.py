"""A program that is planned as fast as its cut allows: a slot in a block, all in a fraction of a second."""

from __future__ import annotations

from functools import cache

import numpy as np

import toolpace as tp
from tests.support.set_up_sheets import milling_sheet
from toolpace.cutting.feeds.limited_plan import CutLimitedPlan, plan_within_cut
from toolpace.cutting.feeds.limits import CutLimits
from toolpace.cutting.feeds.rules import FeedRules
from toolpace.judge.cut.stocks import box_stock
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.programs.tool_figures import ToolFigures


class SLOT:
    """A slot 2 mm deep through a block, with air before and behind."""

    sheet = milling_sheet([(0, -20, -20), (40, 20, 0)], 10, 20, 40, spindle_speed=6000)
    program = """G21 G90 G54 G17
T1 M6
S6000 M3
G0 X-12 Y0 Z-2
G1 X52 F600
G0 Z20
M30
"""
    chip = 0.05e-3
    stock = staticmethod(box_stock(np.array([0.0, -20e-3, -20e-3]), np.array([40e-3, 20e-3, 0.0]), 0.0))
    tools = (ToolFigures("flat", 10e-3, flute_length=20e-3, teeth=3, stick_out=40e-3, material="carbide",
                               spindle_speed=100.0),)  # fmt: skip

    @classmethod
    @cache
    def toolpath(cls) -> tp.ToolPath:
        """The program."""
        return tp.read_text(cls.program, machine(), controller="linuxcnc", setup=setup_of_text(cls.sheet))


@cache
def machine() -> tp.Machine:
    """A trunnion."""
    return tp.Machine.load("xyzac-trunnion")


@cache
def limited_slot(way: str = "limits") -> CutLimitedPlan:
    """The slot, whose chips have a limit."""
    limits = {"": CutLimits(chip=SLOT.chip)} if way == "limits" else {}
    rules = FeedRules(way, air_feed=0.1, finishing=True, limits=limits)
    return plan_within_cut(
        SLOT.toolpath(), machine(), setup_of_text(SLOT.sheet), rules, effort="low", resolution=1e-3
    )
