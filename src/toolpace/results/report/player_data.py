"""What the script of the report shows, from a motion and its program: all in one JSON text, its arrays packed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.errors import printable
from toolpace.motion.setpoints import SetPointSource
from toolpace.results.report.charts import Channel, Curves, binding, deviations, extremes, limit_names
from toolpace.results.report.key_figures import PlanFigures
from toolpace.results.report.keyframes import MOST, TICK, keyframes
from toolpace.results.report.machine_view import machine_view
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.passages import passages
from toolpace.results.report.words import colours, joint_colour, limit_words

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
) -> str:
    """All that the script of the report shows, as JSON that cannot end the element it stands in."""
    shown, arrays = curves.extremes(), PackedArrays()
    if figures is not None:
        shown += deviations(trajectory, setpoints, figures.tip_tolerance_mm, figures.axis_tolerance_deg)
    return page_json(motion_data(trajectory, setpoints, toolpath, shown, program, arrays), arrays)


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
    machine, joints = trajectory.axis_path.machine, setpoints.joints
    columns = min(STRIP, 4 * len(setpoints))
    strip_times = np.asarray((np.arange(columns) + 0.5) * (trajectory.duration / columns), dtype=np.float64)
    passed = passages(trajectory, setpoints, toolpath)
    text = program_text(program)
    return {
        "duration": float(trajectory.duration),
        "joints": [{"name": name, "colour": joint_colour(j)} for j, name in enumerate(joints)],
        "channels": [_channel(channel, arrays) for channel in channels],
        "limits": [limit_words(name) for name in limit_names(joints)],
        "colours": list(colours(joints).values()),
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
