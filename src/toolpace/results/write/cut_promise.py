"""What a plan promised of its cut, put before the judge: as plan.json, the set-up sheet and the program tell it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import msgspec

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.results.write.cut_limits import CutLimitsRecord, input_digests, spindle_curves, tools_of

if TYPE_CHECKING:
    from toolpace.judge.cut import Bent, CutPromise
    from toolpace.judge.cut.stocks import Stock
    from toolpace.judge.verification import Check
    from toolpace.machine.cutting_tool import Coefficients
    from toolpace.machine.machine import Machine
    from toolpace.motion.setpoints import SetPoints
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.stock_figures import StockFigures
    from toolpace.programs.toolpath import ToolPath


@dataclass(frozen=True)
class StatedPromise:
    """What somebody who knows it says was promised; None of what is not said."""

    limits: Mapping[str, Mapping[str, float]] | None = None
    """By tool, "" for all, each in SI by its name."""
    coefficients: Coefficients | None = None
    """Of what is cut."""


NOTHING_STATED = StatedPromise()


def judged_cut(
    record: CutLimitsRecord, file: Mapping[str, Floats | Ints], points: SetPoints, toolpath: ToolPath, setup: SetUp,
    machine: Machine, *, bent: Bent | None = None, stated: StatedPromise = NOTHING_STATED,
) -> tuple[Check, ...]:  # fmt: skip
    """The judge's word on the cut of set-points along a program with its own feeds, and on what plan.json and
    cut_limits.npz say of it; bent: where the path is compensated for the bending of its tool; stated: what the cut was
    promised to be. Raises UsageError for a promise that is none.
    """
    from toolpace.cutting.feeds.limits import CutLimits
    from toolpace.judge.cut import checks_of_cut, not_judged

    check_promise(record)
    if bent is not None and stated.limits is not None:
        # what is compensated counts by what is left of it
        limits = {tool: CutLimits(**each).compensated for tool, each in stated.limits.items()}
        named = {tool: {name: getattr(each, name) for name in each.names} for tool, each in limits.items()}
        stated = replace(stated, limits=named)
    told = told_checks(record, toolpath, setup, stated)
    try:
        promise = promise_of(record, toolpath, setup, machine)
    except UsageError as error:
        return (*told, not_judged(str(error)))
    return (*told, *checks_of_cut(points, toolpath, promise, file, bent))


def told_checks(
    record: CutLimitsRecord, toolpath: ToolPath, setup: SetUp, stated: StatedPromise
) -> tuple[Check, ...]:
    """Whether plan.json tells the promise as sheet, program and material have it; and as it was stated, if it was."""
    from toolpace.judge.verification import Check

    found = []
    kinds = [("plan.json cut_limits", list(other_inputs(record, toolpath, setup)))]
    if stated != NOTHING_STATED:
        kinds.append(("promise of the cut", list(other_promise(record, stated))))
    for what, faults in kinds:
        found += [Check(what, 0.0, 0.0, "", not words, note=words) for words in faults or [""]]
    return tuple(found)


def other_inputs(record: CutLimitsRecord, toolpath: ToolPath, setup: SetUp) -> Iterator[str]:
    """What is not as sheet, program and material have it, a sentence each."""
    from toolpace.cutting.forces.material import Material

    stock = setup.workpiece.stock or toolpath.workpiece.stock
    guessed = stock is None or stock.guessed
    if record.stock_guessed != guessed:
        yield "whether the stock is a guess is not as the set-up sheet says"
    elif stock is not None and not guessed and abs(record.uncertainty_mm - 1e3 * stock.uncertainty) > 1e-9:
        yield "the uncertainty of the stock is not that of the set-up sheet"
    digests = input_digests(toolpath, setup)
    for name in sorted({*digests, *record.inputs}):
        if digests.get(name) != record.inputs.get(name):
            yield f"the figures of {name} are not those that the plan was made with"
    if {name: list(map(tuple, curve)) for name, curve in record.spindle.items()} != spindle_curves(setup.spindle):
        yield "power or torque of the spindle is not as the set-up sheet says"
    if record.material and not record.material.endswith(".toml"):
        try:
            own = msgspec.to_builtins(Material.load(record.material).coefficients)
        except UsageError as error:
            yield str(error)
        else:
            if record.materials.get("") != own:
                yield f"the coefficients are not those of {record.material}"


def other_promise(record: CutLimitsRecord, stated: StatedPromise) -> Iterator[str]:
    """What is not as it was stated, a sentence each."""
    from toolpace.judge.cut import UNITS
    from toolpace.judge.verification import Check

    limits = stated.limits if stated.limits is not None else record.limits
    for tool in sorted({*record.limits, *limits}):
        own, right = record.limits.get(tool, {}), limits.get(tool, {})
        for name in sorted({*own, *right}):
            if own.get(name) != right.get(name):
                shown = Check(name, 0.0, 0.0, UNITS[name], False).show
                words = [shown(each[name]) if name in each else "not limited" for each in (own, right)]
                whose = f" of tool {tool}" if tool else ""
                yield f"{name.replace('_', ' ')}{whose} is {words[0]} in the plan, and {words[1]} as it was stated"
    if stated.coefficients is not None and record.materials.get("") != msgspec.to_builtins(stated.coefficients):
        yield "the coefficients of the material are not those of the material that is stated"


def check_promise(record: CutLimitsRecord) -> None:
    """Raise UsageError where plan.json tells no promise of a cut."""
    from toolpace.cutting.feeds.limits import CutLimits
    from toolpace.cutting.feeds.rules import WAYS
    from toolpace.machine.cutting_tool import Coefficients
    from toolpace.programs.spindle_figures import SpeedCurve

    try:
        for limits in record.limits.values():
            CutLimits(**limits)
        for coefficients in record.materials.values():
            Coefficients(**coefficients)
        for curve in record.spindle.values():
            SpeedCurve(*zip(*curve))
    except (TypeError, UsageError):
        sound = False
    else:
        taught = all(min(each) > 0.0 for teachers in record.teachers.values() for each in teachers)
        sound = record.feeds in WAYS and 0.0 < record.resolution_mm < 1e3 and taught
        sound &= {*record.spindle} <= {"power", "torque"}
    if not sound:
        raise UsageError("plan.json: its cut_limits are no promise of a cut; plan again to write it anew")


def promise_of(record: CutLimitsRecord, toolpath: ToolPath, setup: SetUp, machine: Machine) -> CutPromise:
    """What a plan promises of its cut, as the judge takes it. Raises UsageError where the stock cannot be read."""
    from toolpace.judge.cut import CutPromise
    from toolpace.machine.cutting_tool import Coefficients

    cell, stock = 1e-3 * record.resolution_mm, setup.workpiece.stock or toolpath.workpiece.stock
    return CutPromise(
        feeds=record.feeds,
        stock=largest_stock(stock, machine, setup, cell),
        tools=tools_of(toolpath, setup),
        limits=record.limits,
        coefficients={tool: Coefficients(**each) for tool, each in record.materials.items()},
        teachers=record.teachers,
        resolution=cell,
        margin=cell if stock is not None and stock.uncertainty > 0.0 else 0.0,
        spindle=record.spindle,
        finishing=record.finishing,
        uncertainty=0.0 if stock is None else stock.uncertainty,
    )


def largest_stock(stock: StockFigures | None, machine: Machine, setup: SetUp, cell: float) -> Stock | None:
    """A stock with its uncertainty, as the judge takes it with a margin of a cell [m]; None of one that is not told, or
    a guess. Raises UsageError where its mesh cannot be read."""
    from toolpace.cutting.stock.solids import body_of
    from toolpace.judge.cut.stocks import MeshStock, box_stock, cylinder_stock

    if stock is None or stock.guessed:
        return None
    body = body_of(stock.solid, machine, setup)
    if body.box is not None:
        return box_stock(*body.box, stock.uncertainty)
    if body.cylinder is not None:
        return cylinder_stock(*body.cylinder, stock.uncertainty)
    return MeshStock(body.triangles(), stock.uncertainty, cell)
