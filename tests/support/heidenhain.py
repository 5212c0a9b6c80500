"""Programs written for the tests, and how they are read."""

from __future__ import annotations

import numpy as np

from tests.support.table_table import MACHINE
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.reader import HeidenhainReader
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source

CONTROLLER = Controller.load("heidenhain")
START = "TOOL CALL 1 Z S1000\nL X+0 Y+0 Z+0 R0 FMAX\n"
"""A tool, and a position that all tests begin with."""


def reader(text, machine=None, *, unit="MM", controller=CONTROLLER, name="test.h", begin=START, **options):
    program = f"BEGIN PGM TEST {unit}\n{begin}{text}\nEND PGM TEST {unit}\n"
    source = Source.from_text(program, name)
    return HeidenhainReader(source, machine, controller, ReadOptions(controller, **options), Findings())


def read(text, machine=None, **options):
    """The tool path of the blocks of a program; without machine the tip is where the words are."""
    return reader(text, machine, **options).executed().toolpath()


def findings(text, machine=None, **options):
    """What the reader came upon, with refusals passed over."""
    made = reader(text, machine, skip_unknown=True, **options)
    made.executed().toolpath()
    return made.findings


def tips(text, machine=None, **options):
    """Tips (n, 3) [mm], without the start."""
    return read(text, machine, **options).tip[1:] * 1e3


def last(text, machine=None, **options):
    """Last tip (3,) [mm], rounded to a nanometre."""
    return tuple(np.round(tips(text, machine, **options)[-1], 6) + 0.0)


__all__ = ["CONTROLLER", "MACHINE", "START", "SetUp", "findings", "last", "read", "reader", "tips"]
