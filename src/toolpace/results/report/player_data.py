"""What the script of the report shows, from a motion and its program: all in one JSON text, its arrays packed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import printable
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.motion.setpoints import SetPointSource
from toolpace.results.report.charts import Channel, Curves, binding, deviations, extremes, limit_names
from toolpace.results.report.key_figures import PlanFigures
from toolpace.results.report.keyframes import MOST, TICK, keyframes
from toolpace.results.report.machine_view import machine_view
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.passages import passages
from toolpace.results.report.words import colours, joint_colour, limit_words
from toolpace.results.workpiece.stock_stages import SHARES, StockStages
from toolpace.results.workpiece.tracks import PANELS, STATES, CutTracks
from toolpace.results.workpiece.view import WorkpieceView, outline

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.toolpath import ToolPath

STRIP = 20_000
"""Columns of the strip that shows what limits where: enough to draw it larger ten times on a wide screen."""
STEPS = 4000
"""Values of a curve from 0 to its largest: a screen shows fewer."""
SLOPE = 2.0
"""Rounding of velocities in tolerances of the keyframes [1/s]: over a stretch of 0.1 s an eighth of it is seen."""
LONGEST_PROGRAM = 8_000_000
"""Bytes of a program whose text is in the page: deflated, a million of them."""


def player_data(
    trajectory: Trajectory,
    setpoints: SetPointSource,
    toolpath: ToolPath | None,
    curves: Curves,
    figures: PlanFigures | None,
    program: bytes | None,
    workpiece: WorkpieceView | None = None,
) -> str:
    """All that the script of the report shows, as JSON that cannot end the element it stands in."""
    shown, arrays = curves.extremes(), PackedArrays()
    if figures is not None:
        shown += deviations(trajectory, setpoints, figures.tip_tolerance_mm, figures.axis_tolerance_deg)
    data = motion_data(trajectory, setpoints, toolpath, shown, program, arrays)
    if workpiece is not None:
        data |= workpiece_data(workpiece, arrays)
    return page_json(data, arrays)


def page_json(data: dict[str, object], arrays: PackedArrays) -> str:
    """Data and the arrays that it names, as JSON that cannot end the element it stands in."""
    whole = {**data, "arrays": arrays.text}
    return json.dumps(whole, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def motion_data(
    trajectory: Trajectory,
    setpoints: SetPointSource,
    toolpath: ToolPath | None,
    channels: Sequence[Channel],
    program: bytes | None,
    arrays: PackedArrays,
    most: int = MOST,
) -> dict[str, object]:
    """What player/player.js takes of one motion, its arrays put into `arrays`; `most` keyframes at the most."""
    machine, joints, curves = trajectory.axis_path.machine, setpoints.joints, trajectory.limits.constants.curves
    columns = min(STRIP, 4 * len(setpoints))
    strip_times = np.asarray((np.arange(columns) + 0.5) * (trajectory.duration / columns), dtype=np.float64)
    passed = passages(trajectory, setpoints, toolpath)
    text = program_text(program)
    return {
        "duration": float(trajectory.duration),
        "joints": [{"name": name, "colour": joint_colour(j)} for j, name in enumerate(joints)],
        "channels": [_channel(channel, arrays) for channel in channels],
        "limits": [limit_words(name) for name in limit_names(joints, curves)],
        "colours": list(colours(joints, curves).values()),
        "strip": arrays.add(binding(trajectory, strip_times)),
        "passages": {
            # not after it begins, so that at the moment at which one ends the next is passed
            "t": arrays.add(np.floor(passed.t / TICK) * TICK, TICK),
            "line": arrays.add(passed.line),
            "operation": arrays.add(passed.operation),
            "kind": arrays.add(passed.kind),
        },
        "operations": [
            {"name": printable(each.name), "tool": printable(each.tool)}
            for each in (toolpath.operations if toolpath is not None else ())
        ],
        "program": None if text is None else arrays.add_bytes(text),
        **_motion(trajectory, machine, arrays, most),
    }


def _motion(trajectory: Trajectory, machine: Machine | None, arrays: PackedArrays, most: int) -> dict[str, object]:
    """Keyframes of the joints, and the chain that they move; none without a machine."""
    if machine is None:
        return {"keyframes": None, "machine": None}
    frames = keyframes(trajectory, most)
    lengths = np.asarray(trajectory.axis_path.tool_lengths, dtype=np.float64)
    lengths = np.where(np.isnan(lengths), machine.tool_length, lengths)
    changes = np.flatnonzero(np.diff(lengths, prepend=np.nan) != 0.0)
    return {
        "keyframes": {
            "t": arrays.add(frames.t, frames.tick),
            "q": [arrays.add(each, 0.01 * frames.tolerance) for each in frames.q.T],
            "v": [arrays.add(each, SLOPE * frames.tolerance) for each in frames.qd.T],
        },
        "rotary": machine.is_rotary.tolist(),
        "tools": {
            "t": trajectory.starts[changes].tolist(),
            "length": (1e3 * lengths[changes]).tolist(),
        },
        "machine": machine_view(machine),
    }


def _channel(channel: Channel, arrays: PackedArrays) -> dict[str, object]:
    """A curve for the page."""
    there = channel.values[np.isfinite(channel.values)]
    top = max(float(np.abs(there).max(initial=0.0)), channel.top, 1e-12)
    values = extremes(np.where(np.isfinite(channel.values), channel.values, np.inf))
    return {
        "name": channel.name, "panel": channel.panel, "joint": channel.joint,
        "peak": channel.peak, "unit": channel.unit, "data": arrays.add(values, top / STEPS),
    }  # fmt: skip


def workpiece_data(view: WorkpieceView, arrays: PackedArrays) -> dict[str, object]:
    """Stock, finished part and fixtures in mm, the tools of the operations, and the tracks of the cut."""
    found: dict[str, object] = {
        "workpiece": {
            "stock": None if view.stages is None else _stages(view.stages, arrays),
            "part": None if view.finished_part is None else _mesh(view.finished_part, arrays),
            "fixtures": [_mesh(triangles, arrays) for _, triangles in view.fixtures],
            "tools": [None if each is None else _tool(each) for each in view.tools],
        }
    }
    return found | ({} if view.tracks is None else _tracks(view.tracks, arrays))


def _tool(profile: ToolProfile) -> list[dict[str, object]]:
    """Outlines of its solids: of the cutting part (0), the shank (1) and the holder (2)."""
    solids = [(0, profile.cutting), *((1, each) for each in profile.shank), *((2, each) for each in profile.holder)]
    return [{"part": part, "outline": (1e3 * outline(solid)).round(4).tolist()} for part, solid in solids]


def _stages(stages: StockStages, arrays: PackedArrays) -> dict[str, object]:
    """The crossings of the stock, a column of each."""
    columns = {
        "edge": stages.edge, "place": stages.place + (SHARES + 1) * stages.leaves, "first": stages.first,
        "end": stages.end,
    }  # fmt: skip
    return {
        "origin": (1e3 * stages.origin).tolist(),
        "step": (1e3 * stages.step).tolist(),
        "points": stages.points.tolist(),
        "shares": SHARES,
        "stages": stages.stages,
        "square": stages.square,
        "counts": np.bincount(stages.axis, minlength=3).tolist(),
        **{name: arrays.add(column) for name, column in columns.items()},
    }


def _mesh(triangles: Floats, arrays: PackedArrays) -> dict[str, object]:
    """Corners of triangles, to a thousandth of a millimetre."""
    return arrays.add(1e3 * triangles.ravel(), 1e-3)


def _tracks(found: CutTracks, arrays: PackedArrays) -> dict[str, object]:
    """Curves of the cut over time, by panel, and the band of what the tool does."""
    names = [name for name in PANELS if any(each.panel == name for each in found.tracks)]
    return {
        "panels": [{"name": name, "title": PANELS[name]} for name in names],
        "tracks": [
            {
                "name": each.name, "panel": each.panel, "unit": each.unit, "role": each.role,
                "data": arrays.add(each.values, max(float(np.nan_to_num(each.values).max(initial=0.0)), 1e-9) / STEPS),
            }
            for each in found.tracks
        ],
        "states": {"names": STATES, "data": arrays.add(found.state)},
        "loads": [
            {"name": (f"{each.panel} {each.role}" if each.role else each.name).capitalize(), "track": k}
            for k, each in found.loads()
        ],
    }  # fmt: skip


def program_text(program: bytes | None) -> bytes | None:
    """The lines of a program as UTF-8; None where there are none, or so many that a page would be heavy."""
    if not program or len(program) > LONGEST_PROGRAM:
        return None
    try:
        text = program.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = program.decode("latin-1")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return "\n".join(printable(line.expandtabs(4)) for line in lines).encode()
