"""The figures of a control from a log of its axes, from times that were written down, or from one time.

of a log: acceleration of each axis <- what it keeps up for some rows of it
the rest: least squares, `controls/fitting/least_squares.py`
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.common.units import DEGREE, MILLIMETRE, format_time
from toolpace.controls.fitting.least_squares import Fit, Fitting, Measured, parameters_of
from toolpace.controls.fitting.motion_log import (
    MotionLog,
    is_log,
    load_log,
    noise_of,
    progress,
    sustained_accelerations,
)
from toolpace.controls.fitting.written_times import WrittenTime, load_written_times, written_time
from toolpace.controls.timing.figures import ControlFigures
from toolpace.controls.timing.program_time import PartTime, parts_of
from toolpace.controls.timing.uncertainty import limits_by_axis
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

LOGGED: dict[str, tuple[str, ...]] = {
    "linuxcnc": ("tolerance",),
    "sinumerik": ("tolerance", "jerk"),
    "heidenhain": ("tolerance", "jerk"),
    "fanuc": ("fanuc.corner_difference", "jerk"),
    "lookahead": ("tolerance", "jerk"),
}
"""Figures that a log tells whatever they were before."""
KEPT = 2e-4
"""Deviation of the logarithm of an acceleration that a log shows to be kept for a while, beside its noise."""
SHOWN = 0.02
"""Share of an acceleration that a log shows by which the control's own may be lower, beside two of its deviations."""
LEAST = 1e-3
"""Acceleration that is motion of an axis [mm/s^2, deg/s^2]."""
QUIET = 2e-8
"""Noise of positions that hides neither beginning nor end of the motion [m, rad]."""
WHOLE_ROWS = 1.5
"""Deviation of the whole of a log in rows: one at either end, and a cycle by which model and control may differ."""
INTERPOLATED = {"linuxcnc": 2e-3}
"""Time by which joints move longer than the model's path [s]: LinuxCNC interpolates them over some cycles. Two of 1 ms
are what it took longer for eleven of the programs in benchmarks/results/linuxcnc_times.md, of 4 to 170 seconds."""
LOG_JITTER = 0.05
"""Deviation of a time that a log tells, over the time between rows, at least."""


def fit_log(moves: Commanded, machine: Machine, log: MotionLog, figures: ControlFigures) -> Fit:
    """The figures that come closest to a log of the program. Raises UsageError."""
    _refuse_still(moves)
    found, noise, limits = sustained_accelerations(log)
    units = np.where(machine.is_rotary, DEGREE, MILLIMETRE)
    table = dict(figures.acceleration) if isinstance(figures.acceleration, dict) else {}
    moving = {name: float(a) for name, a in zip(machine.joints, found / units) if a >= LEAST}
    before = limits_by_axis(figures, machine, "acceleration")
    # ramps that end before a limit is reached tell only how high it is at least
    uncertain = {name: KEPT + float(each) for name, each in zip(machine.joints, noise)}
    reached = {name for name, limit in zip(machine.joints, limits) if limit}
    table |= {name: a if name in reached else max(a, before[name]) for name, a in moving.items()}
    start = msgspec.structs.replace(figures, acceleration=table, tolerance=figures.room / MILLIMETRE)
    far, when, doubts = progress(moves, machine, log)
    ended = np.append(when, log.duration)
    # noise hides where motion begins and ends
    exact = int(max(noise_of(column) for column in log.q.T) < QUIET)
    whole = log.duration - INTERPOLATED.get(start.model, 0.0)

    def of_moves(times: Floats) -> Floats:
        end = np.cumsum(times + moves.dwell) - moves.dwell
        return np.append(np.diff(np.append(end[far], end[-1]), prepend=0.0), [end[-1]] * exact)

    measured = Measured(
        np.append(np.diff(ended, prepend=0.0), [whole] * exact),
        np.append(np.full(len(ended), LOG_JITTER * log.dt), [WHOLE_ROWS * log.dt] * exact),
        of_moves,
        log.duration,
        exact,
    )
    parameters = []
    for each in parameters_of(start, machine, LOGGED[start.model]):
        axis = each.figure.axis
        if each.figure.name == "acceleration" and axis in moving:
            shown = math.log(moving[axis] / table[axis]) - SHOWN - 2.0 * uncertain[axis]
            kept = replace(each, deviation=uncertain[axis], measured=True) if axis in reached else each
            parameters.append(replace(kept, least=min(shown, 0.0)))
        elif not axis or axis in moving:
            parameters.append(each)
    fit = Fitting(moves, machine, start, measured, parameters, before).result(LOGGED[start.model][0])
    return replace(fit, doubts=doubts)


def fit_times(
    moves: Commanded,
    machine: Machine,
    written: Sequence[WrittenTime],
    figures: ControlFigures,
    tool_change: float = 0.0,
) -> Fit:
    """The figures that come closest to written times of operations, each with its dwells and tool changes.

    Of one time alone one figure is found. Raises UsageError, for an operation that the program does not have, too.
    """
    _refuse_still(moves)
    parts = parts_of(moves, np.zeros(len(moves)), tool_change)
    waits = np.array([part.time for part in parts])
    rows = [_rows(each.operation, parts, written[:k]) for k, each in enumerate(written)]
    written, rows = _without_total(written, rows)
    chosen = np.array(rows, dtype=float)

    def of_moves(times: Floats) -> Floats:
        spent = np.array([part.cutting + part.rapid for part in parts_of(moves, times, 0.0)])
        return np.asarray(chosen @ (spent + waits))

    seconds = np.array([each.seconds for each in written])
    measured = Measured(seconds, np.array([each.deviation for each in written]), of_moves, float(seconds.sum()))
    fitting = Fitting(moves, machine, figures, measured, parameters_of(figures, machine, ()))
    return fitting.of_one_time() if len(written) == 1 else fitting.result()


def fit_measured(
    measured: str, moves: Commanded, machine: Machine, figures: ControlFigures, tool_change: float = 0.0
) -> Fit:
    """The figures from a log of the axes, a file of written times, or one time (`3:12`), whichever it is.

    Raises UsageError.
    """
    if (whole := written_time(measured)) is not None:
        return fit_times(moves, machine, [whole], figures, tool_change)
    if is_log(measured, machine):
        return fit_log(moves, machine, load_log(measured, machine), figures)
    return fit_times(moves, machine, load_written_times(measured), figures, tool_change)


def _refuse_still(moves: Commanded) -> None:
    if len(moves) < 2:
        raise UsageError(f"{moves.source}: nothing moves in the program: no figure of a control follows from it")


def _without_total(
    written: Sequence[WrittenTime], rows: Sequence[list[bool]]
) -> tuple[list[WrittenTime], list[list[bool]]]:
    """The times without a total that is the sum of all others: it would count the same times twice.

    Raises UsageError where it is the sum of other times.
    """
    total = next((each for each in written if not each.operation), None)
    others = [(each, row) for each, row in zip(written, rows) if each.operation]
    if total is None or not others or not all(sum(column) == 1 for column in zip(*(row for _, row in others))):
        return list(written), list(rows)
    spent, rounding = sum(each.seconds for each, _ in others), sum(each.resolution for each in written)
    if abs(spent - total.seconds) > rounding:
        raise UsageError(
            f"--fit: the total is {format_time(total.seconds)}, and the operations take {format_time(spent)} together; "
            "leave out what is not measured of the moves alone"
        )
    return [each for each, _ in others], [row for _, row in others]


def _rows(operation: str, parts: Sequence[PartTime], before: Sequence[WrittenTime]) -> list[bool]:
    """Which parts of the program a written time is of; of operations with one name each in its turn.

    What is no operation may be a tool, with all that it does: T3.
    """
    if not operation:
        return [True] * len(parts)
    word = operation.lower()
    turn = sum(each.operation.lower() == word for each in before)
    alike = [k for k, part in enumerate(parts) if part.name.strip().lower() == word]
    if not alike:
        of_tool = [f"t{part.tool.lower()}" == word or (part.tool != "" and part.tool.lower() == word) for part in parts]
        if any(of_tool) and not turn:
            return of_tool
        if any(of_tool):
            raise UsageError(
                f"--fit: '{printable(operation)}' is written twice; a tool has one time, of all that it does"
            )
    if turn >= len(alike):
        names = [*dict.fromkeys(part.name or f"T{part.tool}" for part in parts if part.name or part.tool), "total"]
        name = printable(operation[:60])
        if alike:
            raise UsageError(
                f"--fit: '{name}' is written {turn + 1} times, and the program has {len(alike)} of it; remove a line"
            )
        raise UsageError(f"--fit: the program has no operation '{name}'; {printable(did_you_mean(operation, names))}")
    return [k == alike[turn] for k in range(len(parts))]
