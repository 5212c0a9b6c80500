"""Rows of a motion for a control: at its period, in its units.

Set-points are taken, or interpolated between them; exports of rows refuse tool changes. Columns are in mm and degrees,
in other units, or in encoder increments, and what rounding to these moves is worked out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import ANGLES, LENGTHS, format_angle, format_length, format_time
from toolpace.controls.export.target import PlannedMotion
from toolpace.motion.setpoints import SetPoints

WHOLE = 1e-9
"""How far a ratio of two times may be from a whole number and still be one."""
CHUNK = 20_000
"""Rows that are worked out, written or compared at once, to keep memory low."""
QUINTIC_ERROR = 0.006185
"""Largest error of the quintic through value, slope and curvature at both ends of a step of length 1, of a function
whose third derivative stays within 1 of some value (Peano's kernel, worked out numerically; a test does it anew)."""
CYCLES = (1e-6, 1.0)
"""Between which the cycles of controls lie [s]: the fastest current loops take some 10 us, and what is told where to be
less than once a second is not led along a path."""
SAME = 2
"""Time steps within which a tool change by name and one by length are one."""
NAMED = 5
"""Tool changes that a message names."""
MOST_COUNTS = 2.0**53
"""Increments beyond which a double is no whole number any more."""
_LENGTHS = {name: LENGTHS[name] for name in ("um", "mm", "cm", "m", "in")}
_ANGLES = {name: ANGLES[name] for name in ("deg", "rad", "mrad")}


@dataclass(frozen=True)
class Rows:
    """Set-points at a period of their own."""

    points: SetPoints
    period: float
    """[s]"""
    error: Floats
    """(m,) how far positions may be from the planned motion [m, rad]; 0 where they are the plan's own set-points."""
    acceleration: Floats
    """(m,) the highest of the planned motion, between the rows too [m/s^2, rad/s^2]."""

    @property
    def sag(self) -> Floats:
        """(m,) how far a straight line between two rows may be from the motion [m, rad]: a P^2 / 8."""
        sag: Floats = self.acceleration * self.period**2 / 8.0
        return sag


def rows_every(motion: PlannedMotion, period: float, resample: bool = False) -> Rows:
    """The motion every `period` [s], from its start to the first row at or behind its end, where it rests.

    Where the period is a whole number of the plan's time steps these are its own set-points; else they lie between
    them, which must be asked for. Raises UsageError.
    """
    points, dt = motion.setpoints, motion.dt
    if not (math.isfinite(period) and period > 0.0):
        raise UsageError(f"--period {period:g} s: it must be above zero")
    ratio = period / dt
    step = round(ratio)
    whole = step >= 1 and abs(ratio - step) <= WHOLE * step
    rows = math.ceil((len(points) - 1) / ratio * (1.0 - 1e-12)) + 1
    if not whole and not resample:
        raise UsageError(
            f"--period {format_time(period)} is {ratio:.6g} time steps of the plan ({format_time(dt)}), not a whole "
            f"number of them; give --resample to interpolate, or plan again with --dt {period * 1e3:.6g}ms"
        )
    if ratio > len(points) - 1 or rows > 20 * len(points):
        raise UsageError(
            f"--period {format_time(period)} makes {rows} rows of a motion of {format_time(motion.duration)} with "
            f"set-points every {format_time(dt)}; give a period nearer to that"
        )
    t: Floats = period * np.arange(rows, dtype=np.float64)
    highest: Floats = np.abs(points.qdd).max(axis=0)
    if whole:
        index = np.minimum(np.arange(rows) * step, len(points) - 1)
        beyond = np.arange(rows) * step > len(points) - 1
        return Rows(_picked(points, t, index, beyond), period, np.zeros(len(points.joints)), highest)
    return Rows(_between(motion, t), period, _error(motion), highest)


def _picked(points: SetPoints, t: Floats, index: Ints, beyond: Bools) -> SetPoints:
    """Rows of the plan's own; behind its end the machine rests."""
    qd, qdd, qddd = points.qd[index], points.qdd[index], points.qddd[index]
    for rate in (qd, qdd, qddd):
        rate[beyond] = 0.0
    tool = index if points.has_tool else np.zeros(0, dtype=np.int64)
    tip, axis, block = points.tip[tool], points.axis[tool], points.block[index]
    lengths = points.tool_length[index] if len(points.tool_length) else points.tool_length
    return SetPoints(t, points.q[index], qd, qdd, qddd, tip, axis, block, points.joints, lengths)


def _between(motion: PlannedMotion, t: Floats) -> SetPoints:
    """Rows at any times: in each time step the quintic with position, velocity and acceleration of both its ends."""
    points, dt = motion.setpoints, motion.dt
    parts: list[list[Floats]] = [[], [], [], []]
    blocks: list[Ints] = []
    lengths: list[Floats] = [np.zeros(0)]
    for start in range(0, len(t), CHUNK):
        share = t[start : start + CHUNK] / dt
        k = np.minimum(share.astype(np.int64), len(points) - 2)
        beyond = share >= len(points) - 1
        states = quintic(points, k, np.minimum(share - k, 1.0), dt)
        for order, (part, state) in enumerate(zip(parts, states)):
            if order:
                state[beyond] = 0.0
            part.append(state)
        row = np.where(beyond, len(points) - 1, k)
        blocks.append(points.block[row])
        if len(points.tool_length):
            lengths.append(points.tool_length[row])
    q, qd, qdd, qddd = (np.concatenate(part) for part in parts)
    tools = np.concatenate(lengths)
    tip, axis = motion.machine.forward(q, tools) if points.has_tool else (np.empty((0, 3)), np.empty((0, 3)))
    return SetPoints(t, q, qd, qdd, qddd, tip, axis, np.concatenate(blocks), points.joints, tools)


def quintic(points: SetPoints, k: Ints, u: Floats, dt: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Position and three derivatives (n, m) at shares u (n,) of the time steps that begin with set-points k (n,)."""
    q0, v0, a0 = points.q[k], points.qd[k] * dt, points.qdd[k] * dt**2
    q1, v1, a1 = points.q[k + 1], points.qd[k + 1] * dt, points.qdd[k + 1] * dt**2
    x = u[:, None]
    d = q1 - q0 - v0 - 0.5 * a0
    e, f = v1 - v0 - a0, a1 - a0
    c3, c4, c5 = 10.0 * d - 4.0 * e + 0.5 * f, -15.0 * d + 7.0 * e - f, 6.0 * d - 3.0 * e + 0.5 * f
    q = q0 + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))))
    qd = v0 + x * (a0 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))
    qdd = a0 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))
    qddd = 6.0 * c3 + x * (24.0 * c4 + x * 60.0 * c5)
    return q, qd / dt, qdd / dt**2, qddd / dt**3


def _error(motion: PlannedMotion) -> Floats:
    """(m,) bound of the error of the quintics, by what the plan uses of the limits of jerk."""
    jerk = motion.machine.limits.jerk
    if not np.isfinite(jerk).all() or (motion.record is not None and None in motion.record.usage.jerk.values()):
        raise UsageError(
            "--resample: without a limit of jerk nothing bounds what lies between two set-points; plan with "
            "such limits, "
            "or give a period that is a whole number of time steps"
        )
    most: Floats = np.maximum(jerk, np.abs(motion.setpoints.qddd).max(axis=0))
    return QUINTIC_ERROR * most * motion.dt**3


def refuse_no_cycle(option: str, value: float | None) -> None:
    """Raise UsageError, named by the option, where a time that is given is no cycle of a control."""
    if value is None:
        return
    if not (isinstance(value, int | float) and CYCLES[0] <= value <= CYCLES[1]):
        raise UsageError(
            f"{option} {_shown(value)}: give a time from {format_time(CYCLES[0])} to {format_time(CYCLES[1])}; no "
            "control takes positions more often, or follows a path by fewer"
        )


def _shown(value: object) -> str:
    if not isinstance(value, int | float):
        return repr(value)[:40]
    ordinary = math.isfinite(value) and 1e-4 <= abs(value) < 1e6
    return format_time(value) if ordinary else f"{value:.6g} s"


@dataclass(frozen=True, eq=False)
class ToolChange:
    """The machine stands at `time`, and goes on with another tool."""

    time: float
    """[s]"""
    tool: str
    """Its name; empty where it is not known."""
    q: Floats
    """(m,) where the joints stand [m, rad]."""

    def __str__(self) -> str:
        return f"to tool {self.tool or 'of another length'} at {format_time(self.time)}"


def tool_changes(motion: PlannedMotion) -> list[ToolChange]:
    """The changes of a plan in the order of time; the tool that it begins with is none."""
    found = _by_name(motion)
    times = np.array([each.time for each in found])
    for row in _by_length(motion).tolist():
        if not len(times) or np.abs(times - motion.setpoints.t[row]).min() > SAME * motion.dt:
            found.append(_at_rest(motion, row))
    return sorted(found, key=lambda each: each.time)


def refuse_tool_changes(motion: PlannedMotion, name: str) -> None:
    """Raise UsageError where rows that are played without a stop would run through a change of the tool."""
    changes = tool_changes(motion)
    if changes:
        named = ", ".join(map(str, changes[:NAMED])) + (", ..." if len(changes) > NAMED else "")
        raise UsageError(
            f"--to {name}: the plan changes its tool ({named}), and its rows are played without a stop for that; plan "
            "what each tool does as a program of its own, or take --to linuxcnc-g93, which stops, --to program, or "
            "--to table, which gives the times"
        )


def tool_lengths(motion: PlannedMotion, points: SetPoints) -> Floats:
    """(n,) of the tool in the spindle at set-points of a plan [m]."""
    own, of_points = motion.machine.tool_length, points.tool_length
    lengths: Floats = np.where(np.isnan(of_points), own, of_points) if len(of_points) else np.full(len(points), own)
    return lengths


def _by_name(motion: PlannedMotion) -> list[ToolChange]:
    """Those between operations of different tools that have names."""
    found: list[ToolChange] = []
    time, tool = 0.0, ""
    for each in () if motion.record is None else motion.record.operations:
        if each.tool and tool and each.tool != tool:
            found.append(ToolChange(time, each.tool, _stands(motion, time)))
        tool = each.tool or tool
        time += each.time_s
    return [each for each in found if 0.0 < each.time < motion.duration]


def _by_length(motion: PlannedMotion) -> Ints:
    """(k,) rows of the first set-points of a tool of another length."""
    rows: Ints = np.flatnonzero(np.diff(tool_lengths(motion, motion.setpoints))) + 1
    return rows


def _stands(motion: PlannedMotion, time: float) -> Floats:
    """(m,) where the joints are at a time, between two set-points [m, rad]."""
    share = time / motion.dt
    k = min(int(share), len(motion.setpoints) - 2)
    q: Floats = quintic(motion.setpoints, np.array([k]), np.array([min(share - k, 1.0)]), motion.dt)[0][0]
    return q


def _at_rest(motion: PlannedMotion, row: int) -> ToolChange:
    """The change before a set-point: at the slowest one beside it."""
    points = motion.setpoints
    around = np.arange(max(row - SAME, 0), min(row + SAME, len(points)))
    slowest = int(around[np.argmin(np.abs(points.qd[around] / motion.machine.limits.velocity).max(axis=1))])
    return ToolChange(float(points.t[slowest]), "", points.q[slowest])


@dataclass(frozen=True)
class Scale:
    """How each joint is written."""

    units: tuple[str, ...]
    """(m,) of positions: "mm", "deg", "counts"."""
    factors: Floats
    """(m,) from m and rad."""
    counted: tuple[bool, ...]
    """(m,) whether positions are whole numbers."""
    length: tuple[str, float]
    """Unit of the tip, and its factor from m."""

    @property
    def resolution(self) -> Floats:
        """(m,) how far rounding may move a position [m, rad]; 0 for joints that are not counted."""
        return np.where(self.counted, 0.5 / np.abs(self.factors), 0.0)


def scale_of(motion: PlannedMotion, units: str, counts: Mapping[str, str]) -> Scale:
    """The scale of `mm,deg` or the like, and of `X` to `10000/mm` for the joints that are counted.

    Raises UsageError with what is wrong and the units there are.
    """
    parts = [part.strip().lower() for part in units.split(",")]
    lengths, angles = [p for p in parts if p in _LENGTHS], [p for p in parts if p in _ANGLES]
    if len(parts) != 2 or len(lengths) != 1 or len(angles) != 1:
        raise UsageError(
            f"--scale {units[:40]}: give a unit of length ({', '.join(_LENGTHS)}) and one of angle "
            f"({', '.join(_ANGLES)}), like mm,deg"
        )
    for joint in counts:
        if joint not in motion.joints:
            raise UsageError(
                f"--counts {joint[:40]}: the machine has no such joint; {did_you_mean(joint, motion.joints)}"
            )
    if counts and (missing := [joint for joint in motion.joints if joint not in counts]):
        raise UsageError(
            f"--counts: nothing is said of joint {', '.join(missing)}; give all, like {missing[0]}=10000/mm"
        )
    names, factors = [], []
    for joint, turns in zip(motion.joints, motion.rotary):
        if joint in counts:
            names.append("counts")
            factors.append(_per_unit(joint, counts[joint], turns))
        else:
            names.append(angles[0] if turns else lengths[0])
            factors.append(1.0 / (_ANGLES[angles[0]] if turns else _LENGTHS[lengths[0]]))
    counted = tuple(joint in counts for joint in motion.joints)
    scale = Scale(tuple(names), np.array(factors), counted, (lengths[0], 1.0 / _LENGTHS[lengths[0]]))
    most = np.abs(motion.setpoints.q).max(axis=0) * np.abs(scale.factors)
    for joint, value, whole in zip(motion.joints, most, counted):
        if whole and value > MOST_COUNTS:
            raise UsageError(
                f"--counts {joint}={counts[joint]}: {value:.3g} increments are more than a whole number can hold "
                f"({MOST_COUNTS:.3g}); correct the figure"
            )
    return scale


def _per_unit(joint: str, text: str, turns: bool) -> float:
    """Increments for each m or rad, of text such as `10000/mm`; below zero where the encoder counts backwards."""
    units = _ANGLES if turns else _LENGTHS
    figure, _, unit = text.partition("/")
    example = "1000/deg" if turns else "10000/mm"
    try:
        value = float(figure)
    except ValueError:
        value = math.nan
    if unit.strip().lower() not in units:
        kind = "turns" if turns else "moves straight"
        raise UsageError(
            f"--counts {joint}={text[:40]}: joint {joint} {kind}; write increments for each of {', '.join(units)}, "
            f"like {joint}={example}"
        )
    if not (math.isfinite(value) and value != 0.0):
        raise UsageError(
            f"--counts {joint}={text[:40]}: '{figure[:20]}' is no number of increments; like {joint}={example}"
        )
    return value / units[unit.strip().lower()]


def refuse_coarse(motion: PlannedMotion, points: SetPoints, scale: Scale) -> None:
    """Raise UsageError where rounding to increments moves tip or tool axis by more than the plan may stray."""
    if not any(scale.counted):
        return
    tip, axis = _moved(motion, points, scale)
    most_tip, most_axis = motion.tolerances
    if tip <= most_tip and axis <= most_axis:
        return
    share = max(tip / most_tip, axis / most_axis)
    raise UsageError(
        f"--counts: rounding to whole increments moves the tip by up to {format_length(tip)} and the tool axis by "
        f"{format_angle(axis)}, more than the plan may stray ({format_length(most_tip)}, {format_angle(most_axis)}); "
        f"give increments at least {np.ceil(share):.0f} times finer, or leave --counts out"
    )


def _moved(motion: PlannedMotion, points: SetPoints, scale: Scale) -> tuple[float, float]:
    """How far rounding moves the tip [m], and turns the tool axis [rad], at most."""
    tip = axis = 0.0
    for start in range(0, len(points), CHUNK):
        q = points.q[start : start + CHUNK]
        rounded = np.where(scale.counted, np.rint(q * scale.factors) / scale.factors, q)
        lengths = points.tool_length[start : start + CHUNK]
        (here, along), (there, turned) = (motion.machine.forward(each, lengths) for each in (q, rounded))
        tip = max(tip, float(np.linalg.norm(there - here, axis=1).max()))
        chord = float(np.linalg.norm(turned - along, axis=1).max())
        axis = max(axis, 2.0 * float(np.arcsin(min(0.5 * chord, 1.0))))
    return tip, axis
