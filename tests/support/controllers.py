"""Programs read for a controller that is named."""

from __future__ import annotations

import numpy as np

from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.gcode.reader import WordAddressReader
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath


def read_for(controller: str | Controller, body: str, machine=None, name: str = "part.nc", **options) -> ToolPath:
    """The path of a program of a controller."""
    if isinstance(controller, str):
        controller = Controller.load(controller)
    source = Source.from_text(body + "\n", name)
    return WordAddressReader(source, machine, controller, ReadOptions(**options), Findings()).executed().toolpath()


def tips(controller: str | Controller, body: str, machine=None, **options) -> list[list[float]]:
    """Tips in mm, rounded to a nanometre."""
    return (np.round(read_for(controller, body, machine, **options).tip * 1e3, 6) + 0.0).tolist()


def with_options(controller: str, **options: object) -> Controller:
    """A built-in controller whose file says other things."""
    import msgspec

    found = Controller.load(controller)
    return msgspec.structs.replace(found, options=found.options | options)
