"""Tools, stock, finished part and fixtures of a set-up sheet, as the simulation of a cut takes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolpace.common.errors import UsageError
from toolpace.cutting.simulation.simulate import Surroundings, ToolInUse
from toolpace.cutting.simulation.stock_range import StockRange
from toolpace.cutting.stock.dexels import DexelStock, check_memory, resolution_within
from toolpace.cutting.stock.solids import Body, body_of, check_stock_place, guessed_stock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.stock_figures import StockFigures
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

STOCKS = 3
"""That share the memory: see `StockRange`."""
FAR = 0.1
"""Beyond this from all that the tip passes a stock is in the wrong place, or in another unit [m]."""


def tools_in_use(toolpath: ToolPath, setup: SetUp) -> tuple[list[ToolInUse | None], list[str]]:
    """The tool of each operation, and what is assumed of them, a sentence each.

    None where an operation has none: it must not move at feed. Raises UsageError where one that does has no figures.
    """
    cutting = set(toolpath.operation[1:][~toolpath.rapid[1:]].tolist())
    found: list[ToolInUse | None] = []
    assumed: dict[str, None] = {}
    for k, operation in enumerate(toolpath.operations):
        figures = setup.figures_of(operation.tool, operation.figures)
        if figures is None:
            if k in cutting:
                raise UsageError(_without_figures(toolpath, k, setup))
            found.append(None)
            continue
        found.append(ToolInUse(figures, ToolProfile.of(figures)))
        called = f"tool {operation.tool}" if operation.tool else "the only tool"
        if k in cutting and not operation.tool and operation.figures is None:
            assumed["the program names no tool: the only one of the sheet is taken"] = None
        assumed |= {f"{called}: {sentence}": None for sentence in (*figures.assumed, *_unknown(figures))}
    return found, list(assumed)


def _unknown(figures: ToolFigures) -> list[str]:
    """What cannot be checked, as the sheet does not tell it."""
    if figures.stick_out is None:
        return ["stick_out is not told: shank and holder are not checked"]
    if not figures.holder:
        return ["holder is not told: it is not checked"]
    return []


def _without_figures(toolpath: ToolPath, operation: int, setup: SetUp) -> str:
    """Which tool has no figures, and where to write them."""
    each = toolpath.operations[operation]
    line = int(toolpath.block[np.flatnonzero((toolpath.operation == operation) & ~toolpath.rapid)[0]])
    place = f"{toolpath.source or 'the program'}:{line}"
    sheet = setup.source or "a set-up sheet (--setup; inspect --write-setup writes one to fill in)"
    if not each.tool:
        return f"{place}: no tool is named before it cuts; write its only tool as [tools.1] kind, diameter on {sheet}"
    name = each.tool if each.tool.isalnum() else f'"{each.tool}"'
    there = "tells no shape" if setup.tool(each.tool) is not None else "is not on the sheet"
    return f"{place}: tool {each.tool} {there}; write [tools.{name}] with kind, diameter, flute_length on {sheet}"


def stock_range(
    toolpath: ToolPath,
    setup: SetUp,
    machine: Machine,
    tools: Sequence[ToolInUse | None],
    resolution: float | None,
    memory: float,
    finest: float = 0.0,
) -> tuple[StockRange, list[str]]:
    """The stock of the sheet, else that of the program, else a guess; and what is assumed of it, a sentence each.

    With it the same smaller and larger by its uncertainty. finest: of cells [m], where no resolution is wanted.
    Raises UsageError where it is none, or lies elsewhere.
    """
    figures, body = stock_body(toolpath, setup, machine, tools)
    if resolution is not None:
        check_memory(body.triangles(), resolution, memory, STOCKS)
    elif finest > 0.0:
        resolution = max(resolution_within(*body.bounds, memory / STOCKS), finest)
    nominal = dexels(body, resolution, memory / STOCKS)
    notes = [f"stock: {note}" for note in body.notes]
    if figures.guessed or figures.uncertainty == 0.0:
        return StockRange(nominal, nominal, nominal, guessed=figures.guessed), notes
    off = figures.uncertainty
    return StockRange(nominal.shrunk(off), nominal, nominal.grown(off), off), notes


def stock_body(
    toolpath: ToolPath, setup: SetUp, machine: Machine, tools: Sequence[ToolInUse | None]
) -> tuple[StockFigures, Body]:
    """The figures of the stock, and its body in the frame of the part. Raises UsageError as `stock_range`."""
    shapes = [None if tool is None else tool.figures for tool in tools]
    figures = setup.workpiece.stock or toolpath.workpiece.stock or guessed_stock(toolpath, shapes)
    body = body_of(figures.solid, machine, setup)
    low, high = body.bounds
    apart = np.maximum(np.maximum(low - toolpath.tip.max(axis=0), toolpath.tip.min(axis=0) - high), 0.0)
    # a program that only passes by, in air, is a finding
    if body.unit_assumed or float(np.linalg.norm(apart)) > FAR:
        check_stock_place(body, toolpath, shapes, figures.solid.source or "[stock]")
    return figures, body


def check_before_planning(
    toolpath: ToolPath, setup: SetUp, machine: Machine, resolution: float | None, memory: float, *, stock: bool
) -> None:
    """Raise UsageError for what a sheet lacks for a cut: a plan may take minutes. stock: whether the sheet's is cut."""
    tools, _ = tools_in_use(toolpath, setup)
    if stock:
        body = stock_body(toolpath, setup, machine, tools)[1]
        if resolution is not None:
            check_memory(body.triangles(), resolution, memory, STOCKS)
    _bodies_around(setup, machine)


def _bodies_around(setup: SetUp, machine: Machine) -> tuple[Body | None, dict[str, Body]]:
    """The finished part, None where there is none, and the fixtures by name."""
    workpiece = setup.workpiece
    part = None if workpiece.finished_part is None else body_of(workpiece.finished_part, machine, setup)
    return part, {name: body_of(solid, machine, setup) for name, solid in workpiece.fixtures}


def surroundings(setup: SetUp, machine: Machine, resolution: float, memory: float) -> Surroundings:
    """What must not be cut."""
    part, bodies = _bodies_around(setup, machine)
    fixtures = {name: dexels(body, resolution, memory) for name, body in bodies.items()}
    if part is None:
        return Surroundings(fixtures=fixtures)
    finished = dexels(part, resolution, memory)
    return Surroundings(finished, setup.workpiece.gouge_tolerance, fixtures, part.triangles())


def dexels(body: Body, resolution: float | None, memory: float) -> DexelStock:
    """A body as rays."""
    if body.box is not None:
        return DexelStock.box(*body.box, resolution, memory)
    if body.cylinder is not None:
        return DexelStock.cylinder(*body.cylinder, resolution, memory)
    return DexelStock.mesh(body.triangles(), resolution, memory)
