"""The figures of a control, identified from a log of axis positions while it ran a program.

acceleration of each axis <- what it keeps up for some rows of the log
repeat                                                            Nelder and Mead's simplex, in logarithms
  times of the moves <- the model, with these accelerations, and its other figures
  misfit <- differences from when the log has gone as far, and of the whole durations
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.files import reason
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls.timing.axis_motion import axis_ways
from toolpace.controls.timing.figures import ControlFigures
from toolpace.controls.timing.program_time import MODELS
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

TIMES = ("t", "time")
LEAST_ROWS = 20
STEADY = 0.2
"""Most share by which times between rows may differ from their median."""
STILL = 1e-9
"""Way of an axis [m, rad] that is none."""
SEARCHED: dict[str, tuple[str, ...]] = {
    "linuxcnc": ("tolerance",),
    "sinumerik": ("tolerance", "jerk"),
    "heidenhain": ("tolerance", "jerk"),
    "fanuc": ("fanuc.corner_difference", "jerk"),
    "lookahead": ("tolerance", "jerk"),
}
"""Figures that are searched for each model, beside the accelerations, which the log tells by itself; those of a
maker's table with its name."""
TRIED = np.geomspace(0.02, 50.0, 12)
"""Factors of the first figure that are tried first: there may be more than one that fits nearly."""
FARTHEST = math.log(1e3)
"""Most by which a figure leaves what the search begins with, as a logarithm: a log may tell nothing of it."""
SPANS = (1, 2, 3, 5, 8, 13, 21)
"""Rows between which accelerations are differences: more where the log is noisy."""
KEPT_UP = 3
"""Rows over which an acceleration is kept up that counts."""
NOISE = 0.02
"""Most of an acceleration that may be noise."""
WORST = 0.5
"""Misfit over the duration from which a log is no log of the program."""


@dataclass(frozen=True)
class MotionLog:
    """Joint positions at equal times, from the last row at rest to the first at rest again."""

    dt: float
    """Time between rows [s]."""
    q: Floats
    """(n, joints) [m, rad]; nan for joints that the log does not have."""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.dt * (len(self.q) - 1)


def load_log(path: str | Path, machine: Machine) -> MotionLog:
    """A table (CSV): a column `t` in seconds, and one in mm or degrees for each joint, by its name.

    Other columns are passed over. Raises UsageError naming file, line and cure.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as stream:
            lines = csv.reader(stream)
            columns, time = _columns(next(lines, []), machine, str(path))
            wanted = [time, *columns.values()]
            rows = [_row(row, wanted, number, str(path)) for number, row in enumerate(lines, start=2) if row]
    except OSError as error:
        raise UsageError(f"log {path}: cannot be read ({reason(error)}); check the path") from None
    except (UnicodeDecodeError, csv.Error):
        raise UsageError(f"log {path}: no table of text (CSV, UTF-8); export it as one") from None
    if len(rows) < LEAST_ROWS:
        raise UsageError(f"log {path}: has {len(rows)} rows, at least {LEAST_ROWS} are needed; log the whole program")
    table = np.array(rows)
    q = np.full((len(table), len(machine.joints)), np.nan)
    for column, name in enumerate(columns, start=1):
        joint = machine.joints.index(name)
        q[:, joint] = table[:, column] * (DEGREE if machine.is_rotary[joint] else MILLIMETRE)
    return trimmed(_step(table[:, 0], str(path)), q, str(path))


def _columns(header: Sequence[str], machine: Machine, source: str) -> tuple[dict[str, int], int]:
    names = [name.strip() for name in header]
    time = next((names.index(name) for name in TIMES if name in names), None)
    joints = {name: names.index(name) for name in machine.joints if name in names}
    if time is None or not joints:
        raise UsageError(
            f"log {source}: its first line must name the columns: t (seconds) and joints of machine '{machine.name}' "
            f"({', '.join(machine.joints)}), in mm and degrees"
        )
    return joints, time


def _row(row: Sequence[str], wanted: Sequence[int], number: int, source: str) -> list[float]:
    try:
        values = [float(row[column]) for column in wanted]
    except (ValueError, IndexError):
        values = [math.nan]
    if not all(map(math.isfinite, values)):
        raise UsageError(f"log {source}:{number}: a figure is missing or not finite; remove the line, or log anew")
    return values


def _step(t: Floats, source: str) -> float:
    steps = np.diff(t)
    step = float(np.median(steps))
    wrong = np.flatnonzero(np.abs(steps - step) > STEADY * max(step, 0.0))
    if step <= 0.0 or len(wrong):
        line = int(wrong[0]) + 3 if len(wrong) else 3
        raise UsageError(f"log {source}:{line}: times must rise in equal steps (here {step:g} s); log at a fixed rate")
    return float(t[-1] - t[0]) / (len(t) - 1)


def trimmed(dt: float, q: Floats, source: str = "log") -> MotionLog:
    """The rows from the last at rest to the first at rest again. Raises UsageError where no axis moves."""
    moving = np.flatnonzero(np.nanmax(np.abs(np.diff(q, axis=0)), axis=1) > STILL)
    if not len(moving):
        raise UsageError(f"log {source}: no axis moves in it")
    if moving[-1] + 2 - moving[0] < LEAST_ROWS:
        raise UsageError(f"log {source}: the axes move in fewer than {LEAST_ROWS} rows of it; log the whole program")
    return MotionLog(dt, q[moving[0] : moving[-1] + 2])


@dataclass(frozen=True)
class Identified:
    """What a log tells of a control."""

    figures: ControlFigures
    logged: float
    """Duration of the log [s]."""
    modelled: float
    """That of the model with these figures [s]."""
    misfit: float
    """Root mean square of the differences on the way [s]."""


def identify(moves: Commanded, machine: Machine, log: MotionLog, figures: ControlFigures) -> Identified:
    """The figures of the model of `figures` that come closest to a log of the program. Raises UsageError."""
    if len(moves) < 2:
        raise UsageError(f"{moves.source}: nothing moves in the program: no figure of a control follows from it")
    from scipy.optimize import minimize

    start = _with_accelerations(figures, machine, sustained_accelerations(log))
    model, names = MODELS[start.model], SEARCHED[start.model]
    far, when = _progress(moves, machine, log)

    def differences(figures: ControlFigures) -> Floats:
        times = model(moves, machine, figures).times
        end = np.cumsum(times + moves.dwell) - moves.dwell
        return np.asarray(np.append(end[far] - when, end[-1] - log.duration))

    def misfit(logarithms: Floats) -> float:
        off = differences(_scaled(start, names, np.exp(np.clip(logarithms, -FARTHEST, FARTHEST))))
        return float(np.sqrt(np.mean(off[:-1] ** 2)) + abs(off[-1]))

    steps = np.diag([0.2, *[0.5] * (len(names) - 1)])
    tried = np.log(TRIED)[:, None] * np.eye(len(names))[:1]
    first = min(tried, key=misfit)
    found = minimize(
        misfit, first, method="Nelder-Mead",
        options={"initial_simplex": np.vstack([first, first + steps]), "xatol": 2e-3, "fatol": 1e-6 * log.duration,
                 "maxfev": 200},
    )  # fmt: skip
    figures = _scaled(start, names, np.exp(np.clip(found.x, -FARTHEST, FARTHEST)))
    off = differences(figures)
    on_the_way = float(np.sqrt(np.mean(off[:-1] ** 2)))
    if not on_the_way <= WORST * log.duration:
        raise UsageError(
            f"the log takes {log.duration:.4g} s, and the model is {on_the_way:.4g} s off on the way: it is not "
            "the log of this program on this machine, or columns are exchanged"
        )
    return Identified(figures, log.duration, log.duration + float(off[-1]), on_the_way)


def sustained_accelerations(log: MotionLog) -> Floats:
    """(joints,) largest acceleration that each joint keeps up [m/s^2, rad/s^2]; nan where it does not move."""
    return np.array([_sustained(column, log.dt) for column in log.q.T])


def _sustained(q: Floats, dt: float) -> float:
    if not np.isfinite(q).all() or np.ptp(q) == 0.0:
        return math.nan
    found = math.nan
    for span in SPANS:
        second = np.abs(q[2 * span :] - 2.0 * q[span:-span] + q[: -2 * span]) / (span * dt) ** 2
        if len(second) <= KEPT_UP:
            break
        kept = np.min([second[k : len(second) - KEPT_UP + k] for k in range(KEPT_UP)], axis=0)
        found = float(kept.max())
        # fourth differences hold little but noise: 70 of its variances
        noise = math.sqrt(float(np.median(np.diff(q, 4) ** 2)) / (0.455 * 70.0))
        if noise * math.sqrt(6.0) / (span * dt) ** 2 < NOISE * found:
            break
    return found


def _progress(moves: Commanded, machine: Machine, log: MotionLog) -> tuple[Ints, Floats]:
    """Moves whose ends the log passes, and when it does [s], both told by how far the joints have gone by then."""
    ways = axis_ways(moves, machine, joints=True)
    scale = np.where(machine.is_rotary, 0.1, 1.0)  # a radian counts like 0.1 m
    logged = np.isfinite(log.q[0])
    mean = 0.5 * (np.abs(ways.first) + np.abs(ways.last))
    programmed = np.cumsum(np.linalg.norm((mean * scale)[:, logged], axis=1) * ways.length)
    steps = np.linalg.norm(np.diff(log.q[:, logged] * scale[logged], axis=0), axis=1)
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    gone *= programmed[-1] / gone[-1]
    first = np.concatenate([[True], np.diff(gone) > 0.0])
    ends = np.flatnonzero(np.diff(programmed, append=np.inf) > 0.0)
    return ends, np.interp(programmed[ends], gone[first], log.dt * np.flatnonzero(first))


def _with_accelerations(figures: ControlFigures, machine: Machine, found: Floats) -> ControlFigures:
    """The figures with the accelerations of the axes that move in the log; for others the machine's hold."""
    units = np.where(machine.is_rotary, DEGREE, MILLIMETRE)
    table = dict(figures.acceleration) if isinstance(figures.acceleration, dict) else {}
    table |= {name: float(a) for name, a in zip(machine.joints, found / units) if np.isfinite(a) and a > 0.0}
    return msgspec.structs.replace(figures, acceleration=table, tolerance=figures.room / MILLIMETRE)


def _scaled(start: ControlFigures, names: tuple[str, ...], factors: Floats) -> ControlFigures:
    changed: dict[str, object] = {}
    for name, factor in zip(names, factors.tolist()):
        maker, point, figure = name.partition(".")
        if point:
            table = getattr(start, maker)
            changed[maker] = msgspec.structs.replace(table, **{figure: getattr(table, figure) * factor})
            continue
        value = getattr(start, name)
        if isinstance(value, dict):
            changed[name] = {axis: limit * factor for axis, limit in value.items()}
        else:
            changed[name] = value * factor
    return msgspec.structs.replace(start, **changed)
