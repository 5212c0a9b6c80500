"""cut_limits.npz and what plan.json says of it: the speeds that a cut allows, and the engagement they are from."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.files import reason, whole_file
from toolpace.programs.speed_profile import SpeedProfile

if TYPE_CHECKING:
    from toolpace.cutting.feeds.limited_plan import CutLimitedPlan
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.judge.cut import CutPromise
    from toolpace.judge.cut.stocks import Stock
    from toolpace.judge.verification import Check
    from toolpace.machine.machine import Machine
    from toolpace.motion.setpoints import SetPoints
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.stock_figures import StockFigures
    from toolpace.programs.toolpath import ToolPath

CUT_LIMITS = "cut_limits.npz"
"""Its name in the folder of a plan."""
MOST_SLICES = 100_000
OF_STATIONS = ("tip", "axis", "block", "operation")
OF_TABLE = ("feed_direction", "across", "along", "slice", "entry", "exit", "bottom")


class CutLimitsRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What held the speed by the cut."""

    feeds: str
    """air, learned or limits."""
    file: str
    """The profile of speed and the engagement, beside this file."""
    sha256: str
    """Of that file."""
    resolution_mm: float
    stock_guessed: bool
    uncertainty_mm: float
    limits: dict[str, dict[str, float]] = {}
    """By tool, "" for all; each in SI by its name."""
    materials: dict[str, dict[str, float]] = {}
    """Coefficients of the force likewise, in Pa and N/m."""
    teachers: dict[str, list[tuple[float, float, float]]] = {}
    """By tool: chip [m], area [m2] and edge [m] of each."""
    finishing: bool = False
    """Whether speeds are raised where a surface is made that stays, too."""
    notes: list[str] = []


def cut_part(found: CutLimitedPlan, rules: FeedRules) -> tuple[CutLimitsRecord, bytes]:
    """What plan.json says of a plan within its cut, and the bytes of cut_limits.npz."""
    data = cut_bytes(found)
    return cut_record(found, rules, data), data


def cut_record(found: CutLimitedPlan, rules: FeedRules, data: bytes) -> CutLimitsRecord:
    """What plan.json says of a plan within its cut, whose file holds `data`."""
    simulation = found.simulation
    return CutLimitsRecord(
        feeds=rules.way,
        file=CUT_LIMITS,
        sha256=hashlib.sha256(data).hexdigest(),
        resolution_mm=1e3 * simulation.resolution,
        stock_guessed=simulation.guessed,
        uncertainty_mm=1e3 * simulation.uncertainty,
        limits={
            tool: {name: float(getattr(limits, name)) for name in limits.names} for tool, limits in rules.limits.items()
        },
        materials={tool: msgspec.to_builtins(each) for tool, each in rules.materials.items()},
        teachers=_teachers(found),
        finishing=rules.finishing,
        notes=list(found.feeds.notes),
    )


def _teachers(found: CutLimitedPlan) -> dict[str, list[tuple[float, float, float]]]:
    by_tool: dict[str, list[tuple[float, float, float]]] = {}
    for each in found.feeds.teachers:
        by_tool.setdefault(each.tool, []).append((each.chip, each.area, each.edge))
    return by_tool


def cut_bytes(found: CutLimitedPlan) -> bytes:
    """cut_limits.npz of a plan within its cut."""
    profile = found.toolpath.speed_profile
    arrays: dict[str, Floats | Ints] = {}
    if profile is not None:
        arrays |= {"place": profile.place, "speed": profile.speed, "limit": profile.limit}
        arrays["names"] = np.array(profile.names)
    stretches = [each for each in found.simulation.stretches if not each.rapid and len(each.stations) > 1]
    arrays["station time"] = np.concatenate(found.passed)
    arrays["station most"] = np.concatenate(found.feeds.feeds)
    for name in OF_STATIONS:
        arrays[f"station {name}"] = np.concatenate([getattr(each.stations, name) for each in stretches])
    tables = [each.possible for each in stretches]
    for name in OF_TABLE:
        arrays[f"engagement {name}"] = np.concatenate([getattr(each, name) for each in tables])
    arrays["engagement slice_height"] = np.concatenate(
        [np.full(len(each.along), each.slice_height) for each in tables]
    )
    arrays["engagement arcs"] = np.concatenate([np.diff(each.first_arc) for each in tables])
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def judged_cut(
    record: CutLimitsRecord, file: Mapping[str, Floats | Ints], points: SetPoints, toolpath: ToolPath, setup: SetUp,
    machine: Machine, *, bends: bool,
) -> tuple[Check, ...]:  # fmt: skip
    """The judge's word on the cut of set-points along a program with its own feeds, and on what plan.json and
    cut_limits.npz say of it; bends: whether the path is compensated for the bending of its tool."""
    from toolpace.judge.cut import checks_of_cut, not_judged
    from toolpace.judge.verification import Check

    if bends:
        return (not_judged("the tool bends"),)
    try:
        promise = promise_of(record, toolpath, setup, machine)
    except UsageError as error:
        return (not_judged(str(error)),)
    stock = setup.workpiece.stock or toolpath.workpiece.stock
    uncertainty = 0.0 if stock is None or promise.stock is None else 1e3 * stock.uncertainty
    words = ""
    if record.stock_guessed != (promise.stock is None):
        words = "whether the stock is a guess is not as the set-up sheet says"
    elif abs(record.uncertainty_mm - uncertainty) > 1e-9:
        words = "the uncertainty of the stock is not that of the set-up sheet"
    told = Check("plan.json cut_limits", 0.0, 0.0, "", not words, note=words)
    return (told, *checks_of_cut(points, toolpath, promise, file))


def promise_of(record: CutLimitsRecord, toolpath: ToolPath, setup: SetUp, machine: Machine) -> CutPromise:
    """What a plan promises of its cut, as the judge takes it."""
    from toolpace.judge.cut import CutPromise
    from toolpace.machine.cutting_tool import Coefficients

    cell, stock = 1e-3 * record.resolution_mm, setup.workpiece.stock or toolpath.workpiece.stock
    return CutPromise(
        feeds=record.feeds,
        stock=_largest_stock(stock, machine, setup, cell),
        tools=[setup.figures_of(each.tool) or each.figures for each in toolpath.operations],
        limits=record.limits,
        coefficients={tool: Coefficients(**each) for tool, each in record.materials.items()},
        teachers=record.teachers,
        resolution=cell,
        margin=cell if stock is not None and stock.uncertainty > 0.0 else 0.0,
    )


def _largest_stock(stock: StockFigures | None, machine: Machine, setup: SetUp, cell: float) -> Stock | None:
    """A stock with its uncertainty, as the judge takes it with a margin of a cell [m]; None of one that is not told, or
    a guess."""
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


def write_cut(path: Path, data: bytes) -> None:
    """Write it, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(data)


def read_cut(folder: Path, record: CutLimitsRecord | None) -> dict[str, Floats | Ints] | None:
    """The arrays of cut_limits.npz; None where the cut holds nothing. Raises UsageError where plan.json and it differ.
    """
    file = folder / CUT_LIMITS
    if record is None and not file.exists():
        return None
    cure = "plan again to write it anew"
    if record is None or record.file != CUT_LIMITS or not file.exists():
        raise UsageError(f"{file}: plan.json and the file do not belong together; {cure}")
    try:
        data = file.read_bytes()
        if hashlib.sha256(data).hexdigest() != record.sha256:
            raise UsageError(f"{file}: is not the file that the plan was made with (sha256); {cure}")
        return checked(cut_arrays(data))
    except OSError as error:
        raise UsageError(f"{file}: cannot read: {reason(error)}") from None
    except (ValueError, TypeError, KeyError, zipfile.BadZipFile, EOFError):
        raise UsageError(f"{file}: is damaged; {cure}") from None


def cut_arrays(data: bytes) -> dict[str, Floats | Ints]:
    """The arrays in the bytes of cut_limits.npz."""
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def checked(arrays: dict[str, Floats | Ints]) -> dict[str, Floats | Ints]:
    """The same. Raises ValueError where one is missing, has another length, or is of no numbers."""
    count, arcs = len(arrays["station time"]), int(arrays["engagement arcs"].sum())
    of_arcs = {f"engagement {name}" for name in ("slice", "entry", "exit")}
    names = [f"station {name}" for name in (*OF_STATIONS, "time", "most")]
    names += [f"engagement {name}" for name in (*OF_TABLE, "slice_height", "arcs")]
    for name in names:
        found = arrays[name]
        wide = (3,) if name in ("station tip", "station axis", "engagement feed_direction") else ()
        if found.shape != ((arcs if name in of_arcs else count), *wide) or not np.isfinite(found).all():
            raise ValueError(name)
    if arcs and not 0 <= arrays["engagement slice"].min() <= arrays["engagement slice"].max() < MOST_SLICES:
        raise ValueError("slice")
    if not (arrays["engagement slice_height"] > 0.0).all() or (arrays["engagement arcs"] < 0).any():
        raise ValueError("arcs")
    return arrays


def profile_of(arrays: dict[str, Floats | Ints]) -> SpeedProfile | None:
    """The profile of speed in cut_limits.npz; None where there is none. Raises UsageError for what is none."""
    if "place" not in arrays:
        return None
    names = tuple(str(each) for each in arrays["names"])
    return SpeedProfile(arrays["place"], arrays["speed"], arrays["limit"], names)  # type: ignore[arg-type]
