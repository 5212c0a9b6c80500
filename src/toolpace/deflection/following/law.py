"""The law of a follower as one flat array (kernels/follow/layout.py), and as a binary file."""

from __future__ import annotations

import os
import reprlib
import zlib
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import reason, whole_file
from toolpace.common.units import MILLIMETRE
from toolpace.deflection.following.figures import Figures
from toolpace.deflection.following.samples import FollowedJoints, Samples
from toolpace.kernels.follow import layout
from toolpace.machine.machine import Machine

CELL_SAMPLES = 16
"""Samples in a cell, of which the peaks are known."""
TO_CORRECTION = 0.75
"""Share of the reserve that is the correction's; the rest lets the pace be changed where the path uses all it may."""
LEAST_FEED = 1e-5
"""Feed below which a correction is not slowed any further [m/s]."""


def law_of(samples: Samples, driven: FollowedJoints, figures: Figures, pace: float) -> Floats:
    """The piece of a path; `pace` is that of the plan at which it was sampled. Raises UsageError."""
    count, machine = len(samples.q), driven.machine
    q = driven.padded(samples.q)
    spline = control_points(np.column_stack([q, samples.s]))
    share = TO_CORRECTION * figures.reserve if machine is not None else 0.0
    own = correction_limits(share, driven, figures)
    brakes = braking_time(own[:, machine.linear]) if machine is not None else 0.0
    turning = turning_workpiece(machine) if machine is not None else []
    cells = cells_of(samples, spline[:, : layout.JOINTS], brakes, turning)
    refuse_force(samples, machine, figures)
    piece = np.zeros(layout.PATH + spline.size + cells.size + samples.tools.size)
    head = {
        layout.IS_PIECE: layout.MAGIC,
        layout.HAS_VERSION: layout.VERSION,
        layout.SAMPLES: count,
        layout.STEP: samples.step,
        layout.CELLS: len(cells),
        layout.CELL: CELL_SAMPLES * samples.step,
        layout.DURATION: (count - 1) * samples.step,
        layout.PERIOD: figures.period,
        layout.DELAY: figures.delay,
        layout.GAIN: figures.gain,
        layout.MOST: figures.max_correction,
        layout.MOST_TURN: figures.max_turn,
        layout.DEADBAND: figures.deadband,
        layout.FILTER: figures.filter,
        layout.HOLD: figures.hold,
        layout.FADE: figures.fade,
        layout.PATIENCE: figures.patience,
        # without kinematics nothing that is measured of a tool can be made use of
        layout.BELIEVABLE: figures.believable if machine is not None else -1.0,
        layout.CAUSE: layout.DISPLACED if figures.cause == "displaced" else layout.BENDING,
        layout.FEED_SHARE: figures.reserve,
        layout.TIP_PER_LINEAR: samples.reach[0],
        layout.LEVER: max(samples.reach[1], 1e-6),
        layout.NOMINAL: pace,
        layout.WAIT: figures.wait,
        layout.AXIS_TOLERANCE: figures.axis_tolerance,
        layout.RHO: figures.rho,
        layout.TOOLS: len(samples.tools),
        layout.DEAD_TIME: figures.dead_time,
        layout.USED: driven.used,
    }
    for at, value in head.items():
        piece[at] = value
    piece[layout.FRAME : layout.GROUP] = driven.frame
    piece[layout.GROUP : layout.COMPLIANCE].view(np.int64)[:] = np.concatenate([driven.group, driven.place])
    piece[layout.COMPLIANCE : layout.SHARE] = figures.compliance.ravel()
    piece[layout.SHARE : layout.ROOM] = own.ravel()
    piece[layout.ROOM : layout.LOW] = ((1.0 - share) * driven.limits).ravel()
    piece[layout.LOW : layout.PATH] = corrections_within(q, driven, figures).ravel()
    piece[layout.PATH :] = np.concatenate([spline.ravel(), cells.ravel(), samples.tools.ravel()])
    return piece


def control_points(samples: Floats) -> Floats:
    """(n + 3, c) control points of the spline near samples (n, c): it begins at the first, not near it, and rests at
    the last."""
    return np.vstack([2.0 * samples[0] - samples[1], samples, samples[-1], samples[-1]])


def correction_limits(share: float, driven: FollowedJoints, figures: Figures) -> Floats:
    """(3, 5) limits of the correction; any, where nothing is ever corrected."""
    if driven.machine is None:
        return np.ones((3, layout.JOINTS))
    own = share * driven.limits
    own[0] = np.minimum(own[0], fastest(own[1], driven.machine, figures))
    return own


def refuse_force(samples: Samples, machine: Machine | None, figures: Figures) -> None:
    """Raise UsageError where a compliance is given that cannot be that of every tool."""
    if not figures.compliance.any():
        return
    if machine is None:
        raise UsageError("follower: a compliance is of a tool on a machine; give a Machine in place of limits")
    lengths = sorted({machine.tool_length + float(longer) for longer in samples.tools[:, layout.LONGER]})
    if len(lengths) > 1:
        shown = ", ".join(f"{length / MILLIMETRE:g}" for length in lengths)
        raise UsageError(
            f"follower: one compliance for tools of {shown} mm; what a force bends differs from tool to tool: measure"
            " tip or deflection, or plan the program of each tool by itself"
        )


def cells_of(samples: Samples, control: Floats, brakes: float, table: list[int]) -> Floats:
    """(k, CELL_COLUMNS) of the cells, from control points (n + 3, m).

    A correction is slowed down in `brakes` [s]; the joints of `table` turn the workpiece.
    """
    peaks, h = [], samples.step
    for order in (1, 2, 3):
        difference = np.abs(np.diff(control, order, axis=0)) / h**order
        spans = 4 - order
        # a spline on a span is a mean of the differences of the four control points that it touches
        on_span = np.lib.stride_tricks.sliding_window_view(difference, spans, axis=0).max(axis=2)
        peaks.append(_most(on_span[: len(samples.q) - 1]))
    feed = -_most(-np.minimum(samples.feed[:-1], samples.feed[1:])[:, None])
    feed = np.maximum(feed, LEAST_FEED)
    ahead = int(np.ceil(1.2 * brakes / (CELL_SAMPLES * h))) + 2
    turning = peaks[0][:, table].sum(axis=1, keepdims=True) / feed
    return np.concatenate([*peaks, feed, -_most_ahead(-feed, ahead), _most_ahead(turning, ahead)], axis=1)


def _most_ahead(values: Floats, cells: int) -> Floats:
    """(k, 1) largest of values (k, 1) in each cell and the next ones, `cells` in all."""
    most = values.copy()
    for ahead in range(1, cells):
        most[:-ahead] = np.maximum(most[:-ahead], values[ahead:])
    return most


def turning_workpiece(machine: Machine) -> list[int]:
    """The rotary joints that carry the workpiece."""
    return [j for j in machine.rotary if machine.joints[j] in machine.file.chain.workpiece]


def _most(values: Floats) -> Floats:
    """(k, c) largest of values (n, c) in each cell."""
    starts = np.arange(0, len(values), CELL_SAMPLES)
    most: Floats = np.maximum.reduceat(values, starts, axis=0)
    return most


def fastest(acceleration: Floats, machine: Machine, figures: Figures) -> Floats:
    """(m,) what a correction from one end of its range to the other reaches by its acceleration alone."""
    most = np.where(machine.is_rotary, max(figures.max_turn, 1e-6), figures.max_correction)
    speed: Floats = np.sqrt(2.0 * most * acceleration)
    return speed


def braking_time(share: Floats) -> float:
    """Time in which a correction within a share (3, joints) of the limits is slowed down from any velocity [s]."""
    velocity, acceleration, jerk = share
    return float((velocity / acceleration + acceleration / jerk).max())


def corrections_within(q: Floats, driven: FollowedJoints, figures: Figures) -> Floats:
    """(2, m) least and most correction that leaves the joints (n, m) within travel."""
    most = np.where(driven.is_rotary, figures.max_turn, figures.max_correction) * (driven.machine is not None)
    low, high = driven.travel.T
    return np.stack([np.clip(low - q.min(axis=0), -most, 0.0), np.clip(high - q.max(axis=0), 0.0, most)])


def write_law(path: str | os.PathLike[str], piece: Floats) -> None:
    """Write a piece, little-endian, with its checksum, whole or not at all."""
    written = piece.astype("<f8")
    written[layout.CHECKSUM] = checksum(piece)
    with whole_file(path) as temporary:
        temporary.write_bytes(written.tobytes())


def checksum(piece: Floats) -> float:
    """CRC-32 of a piece as it is in a file, with zeros in the checksum's own place."""
    summed = piece.astype("<f8")
    summed[layout.CHECKSUM] = 0.0
    return float(zlib.crc32(summed.tobytes()))


def read_law(path: str | os.PathLike[str]) -> Floats:
    """The piece in a file. Raises UsageError where it is none, of another version, cut short or changed."""
    if not isinstance(path, str | os.PathLike):
        raise UsageError(f"follower: {reprlib.repr(path)[:40]} is no path; give that of a file of Follower.save")
    if Path(path).is_dir():
        raise UsageError(f"{path}: a folder, not a law; Follower.from_folder takes the folder of a plan")
    try:
        content = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: cannot read: {reason(error)}") from None
    piece = np.frombuffer(content[: len(content) // 8 * 8], dtype="<f8").astype(float)
    if len(piece) < layout.PATH or piece[layout.IS_PIECE] != layout.MAGIC:
        raise UsageError(f"{path}: no law of a follower; write one with Follower.save")
    if piece[layout.HAS_VERSION] != layout.VERSION:
        raise UsageError(
            f"{path}: a law of version {piece[layout.HAS_VERSION]:g}, read is {layout.VERSION:g}; write it anew"
        )
    samples, cells = piece[layout.SAMPLES], piece[layout.CELLS]
    tools = layout.TOOL_COLUMNS * piece[layout.TOOLS]
    wanted = layout.PATH + (samples + 3.0) * layout.COLUMNS + cells * layout.CELL_COLUMNS + tools
    if 8.0 * wanted != len(content):
        raise UsageError(f"{path}: {len(content)} bytes where the law needs {8.0 * wanted:g}; write it anew")
    # Counts and indices lead the kernel through memory: no figure of a damaged file may get there.
    if piece[layout.CHECKSUM] != checksum(piece):
        raise UsageError(f"{path}: the law was changed since it was written (its checksum differs); write it anew")
    piece[layout.CHECKSUM] = 0.0
    if (fault := fault_of(piece)) is not None:
        raise UsageError(f"{path}: no follower can play this law: {fault}; write one with Follower.save")
    return piece


def fault_of(piece: Floats) -> str | None:
    """What makes no sense in a piece of the right size, or None: others than Follower.save may have written it."""
    if np.isnan(piece).any():
        return f"figure {int(np.isnan(piece).argmax())} is no number"
    for name, at in (("step", layout.STEP), ("cell", layout.CELL), ("period", layout.PERIOD)):
        if not 0.0 < piece[at] < np.inf:
            return f"its {name} is {piece[at]:g} s"
    if not (piece[layout.SAMPLES] >= 2.0 and piece[layout.CELLS] >= 1.0 and 0.0 <= piece[layout.DURATION] < np.inf):
        return "it has no path"
    if not piece[layout.TOOLS] >= 1.0:
        return "it has no tool"
    if not np.isfinite(piece[-int(piece[layout.TOOLS]) * layout.TOOL_COLUMNS :]).all():
        return "a tool of it has no length"
    if not (piece[layout.USED] in range(1, layout.JOINTS + 1) and piece[layout.DEAD_TIME] >= 0.0):
        return "its joints or its dead time make no sense"
    if not np.isfinite(piece[layout.PATH : layout.PATH + (int(piece[layout.SAMPLES]) + 3) * layout.COLUMNS]).all():
        return "its path leads to infinity"
    group = piece[layout.GROUP : layout.PLACE].view(np.int64)
    place = piece[layout.PLACE : layout.COMPLIANCE].view(np.int64)
    if not (np.isin(group, (0, 1, 2)).all() and np.array_equal(np.sort(place), np.arange(layout.JOINTS))):
        return "its joints are not five, in some order"
    return None
