"""cut_limits.npz and what plan.json says of it: the speeds that a cut allows, and the engagement they are from."""

from __future__ import annotations

import hashlib
import io
import zipfile
from dataclasses import replace
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
    from toolpace.programs.reading.coordinates.setup import SetUp
    from toolpace.programs.spindle_figures import SpindleFigures
    from toolpace.programs.stock_figures import StockFigures
    from toolpace.programs.tool_figures import ToolFigures
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
    material: str = ""
    """Its name, or its file, as it was asked for; empty where that is not known."""
    spindle: dict[str, list[tuple[float, float]]] = {}
    """Its power [W] and its torque [N m] over turns per second [1/s], as far as the set-up sheet tells them."""
    inputs: dict[str, str] = {}
    """SHA-256 of the figures of stock and tools that the plan was made with."""
    teachers: dict[str, list[tuple[float, float, float]]] = {}
    """By tool: chip [m], area [m2] and edge [m] of each."""
    finishing: bool = False
    """Whether speeds are raised where a surface is made that stays, too."""
    notes: list[str] = []


def cut_part(
    found: CutLimitedPlan, rules: FeedRules, setup: SetUp, material: str = ""
) -> tuple[CutLimitsRecord, bytes]:
    """What plan.json says of a plan within its cut, and the bytes of cut_limits.npz."""
    data = cut_bytes(found)
    return cut_record(found, rules, data, setup, material), data


def cut_record(
    found: CutLimitedPlan, rules: FeedRules, data: bytes, setup: SetUp, material: str = ""
) -> CutLimitsRecord:
    """What plan.json says of a plan within its cut, whose file holds `data`; material: its name, as it was asked for.
    """
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
        material=material,
        spindle=spindle_curves(setup.spindle),
        inputs=input_digests(found.toolpath, setup),
        teachers=_teachers(found),
        finishing=rules.finishing,
        notes=list(found.feeds.notes),
    )


def _teachers(found: CutLimitedPlan) -> dict[str, list[tuple[float, float, float]]]:
    by_tool: dict[str, list[tuple[float, float, float]]] = {}
    for each in found.feeds.teachers:
        by_tool.setdefault(each.tool, []).append((each.chip, each.area, each.edge))
    return by_tool


def spindle_curves(spindle: SpindleFigures) -> dict[str, list[tuple[float, float]]]:
    """What a spindle gives: by the name of the limit, turns per second [1/s] and the most at that speed in SI."""
    curves = {"power": spindle.power, "torque": spindle.torque}
    return {name: list(zip(each.speed, each.value)) for name, each in curves.items() if each is not None}


def tools_of(toolpath: ToolPath, setup: SetUp) -> list[ToolFigures | None]:
    """The figures of the tool of each operation."""
    return [setup.figures_of(each.tool, each.figures) for each in toolpath.operations]


def input_digests(toolpath: ToolPath, setup: SetUp) -> dict[str, str]:
    """SHA-256 of the figures of the stock and of each tool, in SI; "stock" and "tool 3"."""
    found = {}
    for operation, tool in zip(toolpath.operations, tools_of(toolpath, setup)):
        if tool is not None:
            found[f"tool {operation.tool}"] = _digest(replace(tool, source="", assumed=()))
    stock = setup.workpiece.stock or toolpath.workpiece.stock
    if stock is not None:
        found["stock"] = _digest(*_parts_of(stock))
    return found


def _parts_of(stock: StockFigures) -> tuple[object, bytes]:
    """Its figures but for the place of its mesh, and the bytes of that."""
    solid = stock.solid
    if solid.mesh is None:
        return replace(stock, solid=replace(solid, source="")), b""
    try:
        data = solid.mesh.read_bytes()
    except OSError:
        data = b""  # what reads it says so
    unit = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    placed = replace(solid, mesh=None, mesh_unit="", box=unit, source="")
    return (replace(stock, solid=placed), solid.mesh_unit), data


def _digest(figures: object, data: bytes = b"") -> str:
    return hashlib.sha256(msgspec.json.encode(figures) + data).hexdigest()


def cut_bytes(found: CutLimitedPlan) -> bytes:
    """cut_limits.npz of a plan within its cut."""
    from toolpace.cutting.feeds.limits import SOURCES

    profile = found.toolpath.speed_profile
    arrays: dict[str, Floats | Ints] = {"names": np.array(SOURCES)}
    if profile is not None:
        arrays |= {"place": profile.place, "speed": profile.speed, "limit": profile.limit}
    stretches = [each for each in found.simulation.stretches if not each.rapid and len(each.stations) > 1]
    arrays["station time"] = np.concatenate(found.passed)
    arrays["station most"] = np.concatenate(found.feeds.feeds)
    arrays["station limit"] = np.concatenate(found.feeds.sources)
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
    names = [f"station {name}" for name in (*OF_STATIONS, "time", "most", "limit")]
    names += [f"engagement {name}" for name in (*OF_TABLE, "slice_height", "arcs")]
    for name in names:
        found = arrays[name]
        wide = (3,) if name in ("station tip", "station axis", "engagement feed_direction") else ()
        if found.shape != ((arcs if name in of_arcs else count), *wide) or not np.isfinite(found).all():
            raise ValueError(name)
    if arcs and not 0 <= arrays["engagement slice"].min() <= arrays["engagement slice"].max() < MOST_SLICES:
        raise ValueError("slice")
    limits = arrays["station limit"]
    if count and not 0 <= limits.min() <= limits.max() < len(arrays["names"]):
        raise ValueError("limit")
    if not (arrays["engagement slice_height"] > 0.0).all() or (arrays["engagement arcs"] < 0).any():
        raise ValueError("arcs")
    return arrays


def profile_of(arrays: dict[str, Floats | Ints]) -> SpeedProfile | None:
    """The profile of speed in cut_limits.npz; None where there is none. Raises UsageError for what is none."""
    if "place" not in arrays:
        return None
    names = tuple(str(each) for each in arrays["names"])
    return SpeedProfile(arrays["place"], arrays["speed"], arrays["limit"], names)  # type: ignore[arg-type]
