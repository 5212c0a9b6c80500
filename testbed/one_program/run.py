"""Write a program in a dialect, read it, compare."""

from __future__ import annotations

from collections import Counter
from functools import cache
from typing import NamedTuple

import msgspec
import numpy as np

from testbed.one_program.compare import difference
from testbed.one_program.controllers import Fanuc, Haas, Iso, LinuxCnc, Mazak, MillPlus
from testbed.one_program.generate import generate
from testbed.one_program.klartext import Klartext
from testbed.one_program.machine import Kinematics
from testbed.one_program.nodes import Program
from testbed.one_program.points import Points
from testbed.one_program.sinumerik import Sinumerik
from testbed.one_program.writer import CannotWriteError, Writer
from toolpace.common.errors import ToolpaceError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.cldata.reader import ClReader
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.languages import reader_of
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

WRITERS: dict[str, type[Writer]] = {
    writer.name: writer for writer in (LinuxCnc, Fanuc, Haas, Iso, Mazak, MillPlus, Sinumerik, Klartext, Points)
}


DOUBTFUL = "fit as a position and as a distance"
"""What MillPlus refuses: centres of arcs that can be meant in both ways."""


class Outcome(NamedTuple):
    """Of one program in one dialect."""

    text: str
    """"" where the dialect has no words for it."""
    fault: str
    """"" where the motion is that of the model."""
    said: Counter[str]
    expanded: Counter[str]


@cache
def machine(name: str) -> Machine:
    return Machine.load(name)


@cache
def controller(name: str, parameters: tuple[tuple[str, object], ...]) -> Controller:
    """With the parameters of a machine."""
    found = Controller.load(name)
    return msgspec.structs.replace(found, options=found.options | dict(parameters))


def set_up(program: Program, dialect: str) -> SetUp:
    """The set-up sheet of a job [m]."""
    if program.machine_zero is None:
        return SetUp()
    built = Kinematics.load(program.machine)
    at_zero = built.linear(np.zeros(3), np.zeros(2), 0.0)
    offsets = {}
    for name, origin in program.offsets.items():
        # the spindle nose, without a tool, at the origin of the offset
        value = (at_zero + origin - program.machine_zero) / 1e3
        told = f"{int(name[1:]) - 53}" if dialect == "heidenhain" else name
        offsets[told] = dict(zip("XYZ", value.tolist()))
    zero = dict(zip("XYZ", (program.machine_zero / 1e3).tolist()))
    tools = {number: Tool(length / 1e3) for number, length in program.tools.items()}
    return SetUp(offsets=offsets, machine_zero=zero, tools=tools)


def read(writer: Writer, text: str) -> ToolPath:
    """What the reader of a dialect makes of a text."""
    dialect, program = writer.name, writer.program
    source = Source.from_text(text, "one.txt")
    if dialect == "cldata":
        return ClReader(source, None, ReadOptions(), Findings()).run()
    by = controller(dialect, tuple(writer.parameters().items()))
    options = ReadOptions(setup=set_up(program, dialect))
    return reader_of(source, machine(program.machine), by, options, Findings()).executed().toolpath()


def tried(dialect: str, seed: int) -> Outcome:
    """One program."""
    program = generate(seed)
    writer = WRITERS[dialect](program)
    try:
        text = writer.write()
    except CannotWriteError as error:
        return Outcome("", "", Counter(), Counter([str(error)]))
    try:
        fault = difference(read(writer, text), writer.world)
    except ToolpaceError as error:
        if DOUBTFUL in str(error):
            return Outcome("", "", Counter(), Counter([DOUBTFUL]))
        fault = f"refused: {error}"
    return Outcome(text, fault, writer.said, writer.expanded)
