"""Tools, stock, finished part and fixtures of a set-up sheet, as the simulation of a cut takes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolpace.common.errors import UsageError
from toolpace.cutting.simulation.simulate import Surroundings, ToolInUse
from toolpace.cutting.simulation.stock_range import StockRange
from toolpace.cutting.stock.dexels import DexelStock
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.stock_figures import Solid, StockFigures
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath


def tools_in_use(toolpath: ToolPath, setup: SetUp) -> tuple[list[ToolInUse | None], list[str]]:
    """The tool of each operation, and what is assumed of them, a sentence each.

    None where an operation has none: it must not move at feed. Raises UsageError where one that does has no figures.
    """
    cutting = set(toolpath.operation[1:][~toolpath.rapid[1:]].tolist())
    found: list[ToolInUse | None] = []
    assumed: dict[str, None] = {}
    for k, operation in enumerate(toolpath.operations):
        figures = setup.figures_of(operation.tool)
        if figures is None:
            if k in cutting:
                raise UsageError(_without_figures(toolpath, k, setup))
            found.append(None)
            continue
        found.append(ToolInUse(figures, ToolProfile.of(figures)))
        called = f"tool {operation.tool}" if operation.tool else "the only tool of the sheet"
        if not operation.tool:
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


def stock_of(toolpath: ToolPath, setup: SetUp, tools: Sequence[ToolInUse | None]) -> StockFigures:
    """The stock of the sheet; else a guess, the box around all cutting moves. Raises UsageError where nothing cuts."""
    if setup.workpiece.stock is not None:
        return setup.workpiece.stock
    at = np.flatnonzero(~toolpath.rapid)
    if not len(at):
        raise UsageError(f"{toolpath.source or 'the program'}: no move is at feed, so that nothing is cut")
    radius = np.array([0.0 if tool is None else tool.profile.radius for tool in tools])[toolpath.operation[at]]
    low = (toolpath.tip[at] - radius[:, None] * [1.0, 1.0, 0.0]).min(axis=0)
    high = (toolpath.tip[at] + radius[:, None]).max(axis=0)
    return StockFigures(Solid(box=(tuple(low.tolist()), tuple(high.tolist()))), 0.0, guessed=True)


def stock_range(figures: StockFigures, resolution: float | None, memory: float) -> StockRange:
    """The stock, and the same smaller and larger by its uncertainty. Raises UsageError."""
    off = 0.0 if figures.guessed else figures.uncertainty
    nominal = dexels(figures.solid, resolution, memory / 3.0)
    if off == 0.0:
        return StockRange(nominal, nominal, nominal)
    return StockRange(nominal.shrunk(off), nominal, nominal.grown(off))


def surroundings(setup: SetUp, resolution: float, memory: float) -> Surroundings:
    """What must not be cut."""
    part = setup.workpiece.finished_part
    return Surroundings(
        None if part is None else dexels(part, resolution, memory),
        setup.workpiece.gouge_tolerance,
        {name: dexels(solid, resolution, memory) for name, solid in setup.workpiece.fixtures},
    )


def dexels(solid: Solid, resolution: float | None, memory: float) -> DexelStock:
    """A solid as rays, in the frame of the part."""
    if solid.box is not None:
        return DexelStock.box(*solid.box, resolution, memory)
    if solid.cylinder is not None:
        return DexelStock.cylinder(*solid.cylinder, resolution, memory)
    raise UsageError(f"{solid.source}: a mesh")
