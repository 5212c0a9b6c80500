"""A log of axis positions that was measured while a control ran a program, and what it tells without a model."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.files import reason
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls.fitting.written_times import written_time
from toolpace.controls.timing.axis_motion import axis_ways, joint_places
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

TIMES = ("t", "time")
"""Headings of the column of times in a log."""
LEAST_ROWS = 20
FARTHEST = 1e9
"""Most of a position [mm, deg]."""
STEADY = 0.2
"""Most share by which times between rows may differ from their median."""
STILL = 1e-9
"""Way of an axis [m, rad] that is none."""
CERTAIN = 6.0
"""Standard deviations of noise beyond which an axis moves."""
SPANS = (1, 2, 3, 5, 8, 13, 21)
"""Rows between which accelerations are differences: more where the log is noisy."""
KEPT_UP = 3
"""Rows over which an acceleration is kept up that counts."""
LARGEST = 1.5
"""Standard deviations of noise that the largest of many accelerations, each the least of KEPT_UP rows, is too high by:
with twice as many the fits of 100 logs held fewer of the real figures."""
LEAST_WAY, MOST_WAY = 0.6, 1.6
"""Ways of a log over that of its program: roundings make them shorter, noise longer."""
ELSEWHERE, LEAST_OFF = 0.2, 2e-3
"""Share of an axis' way, and length [m, rad], by which a log may end elsewhere: tools may differ from the sheet's."""
SHORTER, NOT_THERE = 0.02, 1e-4
"""Share of the way by which a log may be shorter or longer, and distance of its end [m, rad], before it is said."""
IN_MOTION = 0.8
"""Step between the last two rows over the one before, from which the axes do not come to rest there: one third or less
where they do, at most two thirds where noise hides the last of the motion."""
FAST = 20.0
"""Standard deviations of noise in a step that count there: with 8.5 ten of 720 whole logs seemed cut, with 20 none."""
NOISE = 0.01
"""Most of an acceleration that may be noise."""
TOP, RAMP, FLAT = 0.96, 0.3, 0.3
"""Above TOP of the largest acceleration a ramp is at its top, above RAMP it is a ramp; FLAT of it is flat where a limit
is reached. Of a triangle 6 percent are, of half a sine wave 22."""


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

    Between semicolons or tabs figures may have a decimal comma. Other columns are passed over. Raises UsageError naming
    file, line and cure.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as stream:
            header = stream.readline()
            separator = _separator(header)
            columns, time = _columns(next(csv.reader([header], delimiter=separator), []), machine, str(path))
            wanted = [time, *columns.values()]
            lines = enumerate(csv.reader(stream, delimiter=separator), start=2)
            rows = [_row(row, wanted, separator, number, str(path)) for number, row in lines if row]
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


def is_log(path: str | Path, machine: Machine) -> bool:
    """Whether the first line of a file names joints of the machine, or a column `t`, and is no time of an operation."""
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as stream:
            line = stream.readline(10_000)
    except (OSError, UnicodeDecodeError):
        return False
    names = [name.strip() for name in line.split(_separator(line))]
    if len(names) < 2 or written_time(names[-1]) is not None:
        return False
    return not {TIMES[0], *machine.joints}.isdisjoint(names)


def _separator(header: str) -> str:
    """What stands between the cells of a table with this header."""
    return next((each for each in ";\t" if each in header), ",")


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


def _row(row: Sequence[str], wanted: Sequence[int], separator: str, number: int, source: str) -> list[float]:
    point = "." if separator == "," else ","
    try:
        values = [float(row[column].replace(point, ".")) for column in wanted]
    except (ValueError, IndexError):
        values = [math.nan]
    if not all(map(math.isfinite, values)) or max(map(abs, values[1:])) > FARTHEST:
        wrong = f"a figure is missing, not finite or beyond {FARTHEST:g}"
        raise UsageError(f"log {source}:{number}: {wrong}; remove the line, or log anew")
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
    least = np.array([max(STILL, CERTAIN * noise_of(column)) for column in q.T])
    left, there = (np.flatnonzero(np.nanmax(np.abs(q - q[end]) - least, axis=1) > 0.0) for end in (0, -1))
    if not len(left):
        raise UsageError(f"log {source}: no axis moves in it")
    # the last row before the axes leave their first place, the first one in which they are at their last
    first, last = int(left[0]) - 1, int(there[-1]) + 1 if len(there) else len(q) - 1
    if last + 1 - first < LEAST_ROWS:
        raise UsageError(f"log {source}: the axes move in fewer than {LEAST_ROWS} rows of it; log the whole program")
    return MotionLog(dt, q[first : last + 1])


def noise_of(q: Floats) -> float:
    """Standard deviation of the noise of positions (n,): fourth differences hold little else, 70 of its variances."""
    if not np.isfinite(q).all() or len(q) < LEAST_ROWS:
        return 0.0
    return math.sqrt(float(np.median(np.diff(q, 4) ** 2)) / (0.455 * 70.0))


def without_noise(q: Floats, play: float) -> Floats:
    """Positions (n,) that follow the measured ones with some play: they turn only where these do by more than noise."""
    if play <= 0.0:
        return q
    followed, at = np.empty(len(q)), float(q[0])
    for k, value in enumerate(q.tolist()):
        at = min(max(at, value - play), value + play)
        followed[k] = at
    return followed


def sustained_accelerations(log: MotionLog) -> tuple[Floats, Floats, Bools]:
    """Of each joint the largest acceleration that it keeps up [m/s^2, rad/s^2], the share of it that may be noise, and
    whether it is a limit: it is kept for a good part of a ramp. Each (joints,).

    nan where a joint does not move.
    """
    found = [_sustained(column, log.dt) for column in log.q.T]
    values, shares, limits = zip(*found)
    return np.array(values), np.array(shares), np.array(limits, dtype=bool)


def _sustained(q: Floats, dt: float) -> tuple[float, float, bool]:
    if not np.isfinite(q).all() or np.ptp(q) == 0.0:
        return math.nan, math.inf, False
    found, share, limit = math.nan, math.inf, False
    for span in SPANS:
        second = np.abs(q[2 * span :] - 2.0 * q[span:-span] + q[: -2 * span]) / (span * dt) ** 2
        if len(second) <= KEPT_UP:
            break
        kept = np.min([second[k : len(second) - KEPT_UP + k] for k in range(KEPT_UP)], axis=0)
        found = float(kept.max())
        limit = _is_flat(kept > RAMP * found, kept > TOP * found)
        share = LARGEST * noise_of(q) * math.sqrt(6.0) / (span * dt) ** 2 / found if found > 0.0 else math.inf
        if share < NOISE:
            break
    return found, share, limit


def _is_flat(ramps: Bools, top: Bools) -> bool:
    """Whether the ramp (run of true rows) that is longest at its top is flat there.

    Other ramps may be longer, and lower: those in which another axis is at its limit.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ramps, [False]])))
    begin, end = edges[::2], edges[1::2]
    if not len(begin):
        return False
    before = np.concatenate([[0], np.cumsum(top)])
    at_top = before[end] - before[begin]
    longest = int(np.argmax(at_top))
    return bool(at_top[longest] >= FLAT * (end - begin)[longest])


def _compare_course(moves: Commanded, machine: Machine, log: MotionLog, share: float) -> None:
    """Refuse a log whose axes go by far more or less than the program, by their share of its way, or end elsewhere."""
    cure = "log the whole program from its first place on, each axis in its own column, in mm and degrees"
    if not LEAST_WAY <= share <= MOST_WAY:
        raise UsageError(f"log: its axes go {share:.3g} times as far as the program; {cure}")
    off = _end_off(moves, machine, log)
    for axis in np.flatnonzero(off > ELSEWHERE * np.nansum(np.abs(np.diff(log.q, axis=0)), axis=0) + LEAST_OFF):
        told = _distance(machine, int(axis), float(off[axis]))
        raise UsageError(f"log: {told} from where it ends in the program; {cure}")


def _end_off(moves: Commanded, machine: Machine, log: MotionLog) -> Floats:
    """(joints,) by how much more or less each axis goes from its beginning to its end than in the program [m, rad]; 0
    where it is not logged."""
    first, last = joint_places(moves, machine, [0, len(moves) - 1])
    off: Floats = np.nan_to_num(np.abs((log.q[-1] - log.q[0]) - (last - first)))
    return off


def _distance(machine: Machine, axis: int, off: float) -> str:
    unit, scale = ("degrees", DEGREE) if machine.is_rotary[axis] else ("mm", MILLIMETRE)
    return f"{machine.joints[axis]} ends {off / scale:.4g} {unit}"


def _signs_of_a_cut(moves: Commanded, machine: Machine, log: MotionLog, share: float) -> tuple[str, ...]:
    """What tells that rows of a log are missing: motion at its ends, another end, another way; a sentence each."""
    found = [
        f"the axes are in motion where the log {what}: rows are missing there"
        for what, rows in (("begins", log.q[:3]), ("ends", log.q[:-4:-1]))
        if _is_in_motion(rows, log)
    ]
    off = _end_off(moves, machine, log)
    off = np.where(off > NOT_THERE + CERTAIN * np.array([noise_of(column) for column in log.q.T]), off, 0.0)
    for axis in np.flatnonzero(off):
        told = _distance(machine, int(axis), float(off[axis]))
        found.append(
            f"{told} from where it ends in the program: is the log cut, or does the set-up sheet tell another tool or "
            "offset than was used?"
        )
    if abs(share - 1.0) > SHORTER and not found:
        found.append(
            f"the axes go {share:.3g} times as far in the log as in the program: wide roundings, or are rows missing?"
        )
    return tuple(found)


def _is_in_motion(rows: Floats, log: MotionLog) -> bool:
    """Whether axes do not come to rest at the first of three rows (3, joints), which are the nearest to an end."""
    last, before = np.abs(np.diff(rows, axis=0))
    certain = np.array([max(STILL, FAST * noise_of(column)) for column in log.q.T])
    return bool(np.any((last > certain) & (last > IN_MOTION * before)))


def progress(moves: Commanded, machine: Machine, log: MotionLog) -> tuple[Ints, Floats, tuple[str, ...]]:
    """Moves whose ends the log passes, and when it does [s], both told by how far the joints have gone by then; and
    what tells that rows of the log are missing.

    Raises UsageError where the log is not of the whole program.
    """
    ways = axis_ways(moves, machine, joints=True)
    scale = np.where(machine.is_rotary, 0.1, 1.0)  # a radian counts like 0.1 m
    logged = np.isfinite(log.q[0])
    mean = 0.5 * (np.abs(ways.first) + np.abs(ways.last))
    programmed = np.cumsum(np.linalg.norm((mean * scale)[:, logged], axis=1) * ways.length)
    columns = [without_noise(column, CERTAIN * noise_of(column)) for column in log.q[:, logged].T]
    steps = np.linalg.norm(np.diff(np.column_stack(columns) * scale[logged], axis=0), axis=1)
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    share = float(gone[-1] / programmed[-1]) if programmed[-1] > 0.0 else math.inf
    _compare_course(moves, machine, log, share)
    gone *= programmed[-1] / gone[-1]
    first = np.concatenate([[True], np.diff(gone) > 0.0])
    ends = np.flatnonzero(np.diff(programmed, append=np.inf) > 0.0)
    passed = np.interp(programmed[ends], gone[first], log.dt * np.flatnonzero(first))
    return ends, passed, _signs_of_a_cut(moves, machine, log, share)
