"""Reads programs that tests write."""

from __future__ import annotations

import functools

import numpy as np

from toolpace.machine.machine import Machine
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.sinumerik.reader import SinumerikReader
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

SINUMERIK = Controller.load("sinumerik")
START = "G54 G64 G90 G71 F1000\nG0 X0 Y0 Z0\n"
"""A head that puts the tool to the origin."""


@functools.cache
def machine(name: str) -> Machine:
    return Machine.load(name)


def read(text: str, on: str | None = None, *, start: str = START, name: str = "part.mpf", **options) -> ToolPath:
    """The tool path of a program; `start` stands before it, M30 behind."""
    setup = options.pop("setup", None) or SetUp()
    controller = options.pop("controller", SINUMERIK)
    source = Source.from_text(f"{start}{text}\nM30\n", name)
    given = ReadOptions(controller=controller, setup=setup, **options)
    return (
        SinumerikReader(source, None if on is None else machine(on), controller, given, Findings())
        .executed()
        .toolpath()
    )


def ends(text: str, on: str | None = None, **options) -> np.ndarray:
    """Tips [mm] at the ends of the blocks of a program, without those between: one a line that moves."""
    path = read(text, on, **options)
    last = np.flatnonzero(np.append(np.diff(path.block) != 0, True))
    return path.tip[last] * 1e3


def last(text: str, on: str | None = None, **options) -> list[float]:
    """Where a program ends [mm]."""
    return (read(text, on, **options).tip[-1] * 1e3).tolist()
