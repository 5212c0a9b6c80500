"""Limits and travel of an axis, and how the control uses them: acceleration, jerk, roundings, cycles.

Function Manual Basic Functions, B1 (continuous-path mode), B2 (acceleration: with SOFT an axis has MD32300 times
MD32433; with DRIVE it falls beyond a knee, 2.18), A3 (software limit switches do not hold for modulo axes), G2 (units:
mm/min, m/s2, m/s3; with inches in/min, in/s2, in/s3; rev/min, rev/s2, rev/s3). Of data for each dynamic mode the first
is DYNNORM; then come DYNPOS, DYNROUGH, DYNSEMIFIN, DYNFINISH.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

from toolpace.machine.from_control.record import Figure, MachineRecord, Origin, lowest, travel
from toolpace.machine.from_control.sinumerik.channel_axes import ChannelAxis
from toolpace.machine.from_control.sinumerik.machine_data import MachineData

NAMES = {"velocity": "MA_MAX_AX_VELO", "acceleration": "MA_MAX_AX_ACCEL", "jerk": "MA_MAX_AX_JERK"}
KNEE = ("SPEED_POINT", "FACTOR", "TYPE")
UNITS = {
    "mm": ("mm/min", "m/s2", "m/s3"),
    "in": ("in/min", "in/s2", "in/s3"),
    "deg": ("rpm", "rev/s2", "rev/s3"),
}
"""Of velocity, acceleration and jerk."""
UNLIMITED = 1e7
"""A software limit switch from here on is none: the control's own default is 1e8 [mm, in, deg]."""
CONSTANT, HYPERBOLIC, LINEAR = 0.0, 1.0, 2.0
"""How acceleration falls beyond the knee: MD35242, the second where it is not told."""
JUMP = 0.95
"""Share of the velocity at which acceleration jumps down, from which it falls here."""
TANGENTS = 8
"""Of a hyperbola, between which its corners lie: they are below it, by at most 1 percent from a fifth of the velocity
on."""
ROUGH, SEMIFINISH, FINISH = 2, 3, 4
"""Indices of dynamic modes."""
SOFT_OR_BRISK, BRISK = 20, 1
"""Index of their group in MD20150 GCODE_RESET_VALUES, and the value that is BRISK."""
FACTORS = (0.01, 100.0)
"""Least and most of a factor in a controller file."""


def joint_figures(data: MachineData, axis: ChannelAxis, kind: Figure, length: str) -> dict[str, Figure]:
    """Limits and travel of a joint, by the keys of a machine file; what no file tells is left out.

    `length` is "mm" or "in". Raises ControlFileError.
    """
    rotary = kind.value == "rotary"
    units = UNITS["deg" if rotary else length]
    figures = {"kind": kind}
    for (key, name), unit in zip(NAMES.items(), units):
        figure = data.figure(name, 0, axis.words, unit)
        if figure is not None:
            figures[key] = _above_zero(figure)
    if "velocity" not in figures and (jog := data.figure("MA_JOG_VELO_RAPID", 0, axis.words, units[0])) is not None:
        figures["velocity"] = _above_zero(jog)
    soft = data.figure("MA_SOFT_ACCEL_FACTOR", 0, axis.words)
    if soft is not None and soft.number != 1.0 and (brisk := figures.get("acceleration")) is not None:
        share = _above_zero(soft).number
        figures["acceleration"] = Figure(share * brisk.number, brisk.origins + soft.origins, brisk.unit)
    if "acceleration" in figures:
        figures["acceleration"] = _with_knee(data, axis, figures["acceleration"])
    return figures | _reach(data, axis, rotary)


def _with_knee(data: MachineData, axis: ChannelAxis, acceleration: Figure) -> Figure:
    """The acceleration as it falls beyond a share of the velocity; as it is, where that is the whole of it.

    At the velocity limit 1 - MD35230 of it is left.
    """
    at, less, kind = (data.figure(f"MA_ACCEL_REDUCTION_{name}", 0, axis.words) for name in KNEE)
    if at is None or less is None or at.number >= 1.0 or less.number == 0.0:
        return acceleration
    if at.number < 0.0:
        raise at.origins[0].error(f"= {at.number:g}; give a share of the velocity, 0 to 1")
    if not 0.0 < less.number < 1.0:
        raise less.origins[0].error(f"= {less.number:g}; give a share of the acceleration, 0 to 0.95")
    shape = HYPERBOLIC if kind is None else kind.number
    if kind is not None and shape not in (CONSTANT, HYPERBOLIC, LINEAR):
        raise kind.origins[0].error(f"= {shape:g}; give 0 (constant), 1 (hyperbolic) or 2 (linear)")
    knee, left = at.number, 1.0 - less.number
    if knee == 0.0:
        falls = [(0.0, 1.0), (1.0, left)] if shape == LINEAR else [(0.0, left)]
    elif shape == CONSTANT:
        falls = [(0.0, 1.0), (JUMP * knee, 1.0), (knee, left)]
    else:
        falls = [(0.0, 1.0), (knee, 1.0), *(_hyperbola(knee, left) if shape == HYPERBOLIC else ()), (1.0, left)]
    origins = tuple(origin for each in (at, less, kind) if each is not None for origin in each.origins)
    return replace(acceleration, origins=acceleration.origins + origins, falls=tuple(falls))


def _hyperbola(knee: float, left: float) -> list[tuple[float, float]]:
    """Corners below the hyperbola b + c / v from 1 at the knee to `left` at 1: where tangents at even ratios of v
    meet."""
    c = (1.0 - left) * knee / (1.0 - knee)
    touched = [knee ** (1.0 - k / TANGENTS) for k in range(TANGENTS + 1)]
    pairs = list(pairwise(touched))
    return [(2.0 * one * two / (one + two), left - c + 2.0 * c / (one + two)) for one, two in pairs]


def _above_zero(figure: Figure) -> Figure:
    if not figure.number > 0.0:
        raise figure.origins[0].error(f"= {figure.number:g}; give a number above zero")
    return figure


def _reach(data: MachineData, axis: ChannelAxis, rotary: bool) -> dict[str, Figure]:
    """The travel; without end for a modulo axis, and for a turning axis that nothing limits."""
    modulo = data.figure("MA_ROT_IS_MODULO", 0, axis.words)
    if rotary and modulo is not None and modulo.number:
        return {"wrap": Figure(True, modulo.origins)}
    low, high = (data.figure(f"MA_POS_LIMIT_{side}", 0, axis.words) for side in ("MINUS", "PLUS"))
    low = None if low is not None and low.number <= -UNLIMITED else low
    high = None if high is not None and high.number >= UNLIMITED else high
    if low is not None and high is not None:
        return {"travel": travel(low, high)}
    if rotary and low is None and high is None:
        return {"wrap": Figure(True, (Origin("neither $MA_POS_LIMIT_MINUS nor $MA_POS_LIMIT_PLUS limits its travel"),))}
    return {}


def add_dynamics(data: MachineData, record: MachineRecord, axes: Mapping[str, ChannelAxis]) -> None:
    """The figures of [time] of a controller file, and what a person should know of the modes.

    Where axes have different figures, the model has the one of the least motion. Raises ControlFileError.
    """
    record.controller = "sinumerik"
    timing = record.timing
    timing["model"] = Figure("sinumerik", (Origin("the control is a Sinumerik"),))
    in_mm = 25.4 if record.length.value == "in" else 1.0
    straight = [axis for name, axis in axes.items() if name in "XYZ"]
    turning = [axis for name, axis in axes.items() if name not in "XYZ"]
    for key, of, factor in (("tolerance", straight, in_mm), ("axis_tolerance", turning, 1.0)):
        found = [data.figure("MA_COMPRESS_POS_TOL", 0, axis.words) for axis in of]
        _add(timing, key, [figure and Figure(factor * figure.number, figure.origins) for figure in found], (1e-4, 1e9))
    both = straight + turning
    for key, name, ends in (
        ("sinumerik.rapid_acceleration", "G00_ACCEL_FACTOR", FACTORS),
        ("sinumerik.rapid_jerk", "G00_JERK_FACTOR", FACTORS),
        ("sinumerik.overload", "MAX_ACCEL_OVL_FACTOR", (1.0, 100.0)),
    ):
        _add(timing, key, [data.figure(f"MA_{name}", 0, axis.words) for axis in both], ends)
    _add(timing, "sinumerik.curve_share", [data.figure("MC_CURV_EFFECT_ON_PATH_ACCEL")], (0.0, 0.95))
    for key, name, mode in (
        ("sinumerik.transition_jerk", "MA_PATH_TRANS_JERK_LIM", 0),
        ("sinumerik.jerk_rough", "MA_MAX_AX_JERK", ROUGH),
        ("sinumerik.jerk_semifinish", "MA_MAX_AX_JERK", SEMIFINISH),
        ("sinumerik.jerk_finish", "MA_MAX_AX_JERK", FINISH),
    ):
        _add(timing, key, [_over_jerk(data, axis, name, mode) for axis in both], FACTORS)
    _add(timing, "sinumerik.cycle", [_cycle(data)], (1e-6, 0.1))
    after_reset = data.figure("MC_GCODE_RESET_VALUES", SOFT_OR_BRISK)
    if after_reset is not None:
        timing["sinumerik.brisk"] = Figure(float(after_reset.number == BRISK), after_reset.origins)
    path = data.figure("MC_MAX_PATH_JERK")
    if path is not None:
        record.control_figures[f"jerk of the path [{'m' if in_mm == 1.0 else 'in'}/s^3]"] = path
    record.remarks += _modes(data, axes)
    record.remarks += [
        f"Acceleration of {name} falls with its velocity ($MA_ACCEL_REDUCTION_SPEED_POINT): the control keeps that "
        "with DRIVE, the machine here at any time."
        for name, joint in record.joints.items()
        if "acceleration" in joint and joint["acceleration"].falls
    ]


def _add(timing: dict[str, Figure], key: str, figures: Iterable[Figure | None], ends: tuple[float, float]) -> None:
    """Keep the lowest of figures that are set (0 is not), within what a model takes: defaults can be 1e6."""
    present = [figure for figure in figures if figure is not None and figure.number > 0.0]
    if not present:
        return
    least = lowest(present)
    value = min(max(least.number, ends[0]), ends[1])
    note = (Origin(f"{least.number:g} is beyond what the model takes"),) if value != least.number else ()
    timing[key] = Figure(value, least.origins + note)


def _over_jerk(data: MachineData, axis: ChannelAxis, name: str, mode: int) -> Figure | None:
    """A jerk of an axis over that of DYNNORM."""
    usual, other = data.figure("MA_MAX_AX_JERK", 0, axis.words), data.figure(name, mode, axis.words)
    if usual is None or other is None or not usual.number > 0.0:
        return None
    return Figure(other.number / usual.number, other.origins + usual.origins)


def _cycle(data: MachineData) -> Figure | None:
    """The cycle of the interpolator [s]: MD10071, or MD10050 times MD10070."""
    direct = data.figure("MN_IPO_CYCLE_TIME")
    if direct is not None:
        return direct
    base, ratio = data.figure("MN_SYSCLOCK_CYCLE_TIME"), data.figure("MN_IPO_SYSCLOCK_TIME_RATIO")
    if base is None or ratio is None:
        return None
    return Figure(base.number * ratio.number, base.origins + ratio.origins)


def _modes(data: MachineData, axes: Mapping[str, ChannelAxis]) -> Iterator[str]:
    """Which limits differ from one dynamic mode to another."""
    for name in (NAMES["acceleration"], NAMES["jerk"]):
        for letter, axis in axes.items():
            values = [data.figure(name, mode, axis.words) for mode in range(FINISH + 1)]
            present = [figure.number for figure in values if figure is not None]
            if len(present) > 1 and not all(math.isclose(value, present[0]) for value in present):
                shown = ", ".join(f"{value:g}" for value in present)
                yield f"${name} of {letter} differs by dynamic mode ({shown}): the machine has that of DYNNORM."
