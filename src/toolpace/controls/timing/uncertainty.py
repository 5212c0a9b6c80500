"""The range of a control's time, from the uncertainty of its figures.

for each uncertain figure: the time with it at either end of its uncertainty, all others as they are
least, most <- the time with every figure at its faster end at once, and with every one at its slower end
               then each turned over once, where that is faster or slower with all others where they are now

So a control whose figures all lie within their uncertainties takes a time within the range, as far as time rises or
falls evenly with each figure. Nothing is taken for independent. The rules of the model count as right.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from toolpace.common.errors import UsageError, did_you_mean, in_short
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.controls.timing.figures import ControlFigures, Spread, limits_of

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

Ends = tuple[float, float]
LIMITS = ("acceleration", "jerk")
"""Figures that differ by axis."""
LEAST_TOLERANCE = 1e-4
"""[mm]"""
SAME = 1e-9
"""Share by which times of one motion may differ by rounding: a figure that changes a time by less does not matter."""
USUAL: dict[str, dict[str, Spread]] = {
    # its INI file says the limits, and the planner keeps them
    "linuxcnc": {"acceleration": 1.05, "jerk": 1.05, "tolerance": 1.2},
    "sinumerik": {
        "acceleration": 1.2, "jerk": 2.0, "tolerance": 1.5, "sinumerik.overload": [1.1, 1.4], "sinumerik.cycle": 2.0,
        "sinumerik.transition_jerk": 2.0, "sinumerik.curve_share": [0.0, 0.25],
    },
    # the filter's length follows from jerk and tolerance
    "heidenhain": {"acceleration": 1.2, "jerk": 2.0, "tolerance": 1.5, "heidenhain.path_jerk": 1.5},
    "fanuc": {
        "acceleration": 1.2, "jerk": 2.0, "fanuc.corner_difference": 2.0, "fanuc.corner_difference_rotary": 2.0,
        "fanuc.curve_acceleration": 1.5, "fanuc.arc_acceleration": 1.5, "fanuc.after_interpolation": [0.0, 0.03],
    },
    "lookahead": {"acceleration": 1.2, "jerk": 2.0, "tolerance": 2.0},
}  # fmt: skip
"""Where the controller's file says nothing (assumption). Builders set acceleration near the data sheet, and jerk as
smoothness asks for: machine files mostly hold ten times the acceleration. MD20602 is a quarter where a knee is set."""


@dataclass(frozen=True)
class UncertainFigure:
    """A figure of a control and the ends between which it lies."""

    name: str
    """As in the controller's file: `jerk`, `fanuc.corner_difference`."""
    axis: str
    """Of a limit of one axis; empty of a figure that holds for all."""
    factors: Ends
    """Both ends over the figure; of one that is zero both ends themselves."""

    def at(self, end: float, figures: ControlFigures, machine: Machine) -> ControlFigures:
        """The figures with this one at an end, or any other factor. Raises UsageError where it cannot be so."""
        if self.axis:
            return with_limit(figures, machine, self.name, self.axis, end)
        value = figure_of(figures, self.name)
        if isinstance(value, dict):
            return with_figure(figures, self.name, {axis: each * end for axis, each in value.items()})
        changed = value * end if value else end
        return with_figure(figures, self.name, max(changed, LEAST_TOLERANCE) if self.name == "tolerance" else changed)

    def unit(self, machine: Machine) -> str:
        """In which the figure stands; empty where its maker's manual says it."""
        if self.name in LIMITS:
            length = "deg" if self.axis and machine.is_rotary[machine.joints.index(self.axis)] else "mm"
            power = 2 + LIMITS.index(self.name)
            return f"{length}/s^{power}" if self.axis else "times the machine's"
        return "mm" if self.name == "tolerance" else ""

    def __str__(self) -> str:
        words = self.name.rpartition(".")[2].replace("_", " ")
        return f"{words} of {self.axis}" if self.axis else words


@dataclass(frozen=True)
class FigureEffect:
    """What the uncertainty of one figure makes of the time, all other figures as they are."""

    figure: str
    """In words: "jerk of X"."""
    least: float
    """[s]"""
    most: float
    """[s]"""

    @property
    def width(self) -> float:
        """[s]"""
        return self.most - self.least


@dataclass(frozen=True)
class TimeRange:
    """Between which times a control takes, by the uncertainty of its figures."""

    least: float
    """With every figure at its faster end [s]."""
    most: float
    """With every figure at its slower end [s]."""
    effects: tuple[FigureEffect, ...] = ()
    """Of each figure that matters, that of the largest first; of a figure for all axes also by axis, behind it."""
    mostly: str = ""
    """From which figures more than half of the range is: "jerk of X"; empty where no figure matters."""


def time_range(
    total: Callable[[ControlFigures], float],
    machine: Machine,
    figures: ControlFigures,
    middle: float,
    thorough: bool = True,
) -> TimeRange:
    """The range of the time that `total` [s] tells for figures; it tells `middle` for these. Raises UsageError.

    thorough: whether figures are turned over, and limits told by axis.
    """

    def effect(figure: UncertainFigure) -> tuple[FigureEffect, Ends]:
        """And its ends, that first with which the control is faster."""
        times = [total(figure.at(end, figures, machine)) for end in figure.factors]
        times = [middle if math.isclose(each, middle, rel_tol=SAME) else each for each in times]
        ends = figure.factors if times[0] <= times[1] else figure.factors[::-1]
        return FigureEffect(str(figure), min(middle, *times), max(middle, *times)), ends

    uncertain = uncertain_figures(figures, machine)
    found, ends = [], []
    for each in uncertain:
        made, quick_slow = effect(each)
        found.append(made)
        ends.append(quick_slow)
    if not any(each.width > 0.0 for each in found):
        return TimeRange(middle, middle)

    def at(chosen: Sequence[float]) -> float:
        changed = figures
        for each, end in zip(uncertain, chosen):
            changed = each.at(end, changed, machine)
        return total(changed)

    turned = len(ends) if thorough else 0
    least = min(-_largest(lambda chosen: -at(chosen), ends, turned), *(each.least for each in found))
    most = max(_largest(at, [pair[::-1] for pair in ends], turned), *(each.most for each in found))
    effects = _ranked(found)
    names = _most_of(effects)
    split: list[FigureEffect] = []
    if thorough and names and names[0] in LIMITS:
        (common,) = (each for each in uncertain if str(each) == names[0])
        split = _ranked(effect(replace(common, axis=axis))[0] for axis in machine.joints)
        axes = [each.rpartition(" ")[2] for each in _most_of(split)]
        names[0] += f" of {' and '.join(axes)}" if axes else ""
    return TimeRange(least, most, (*effects, *split), ", and ".join(names))


def _largest(value: Callable[[Sequence[float]], float], ends: Sequence[Ends], turned: int) -> float:
    """The largest value over ends of all figures at once: the first, and so many turned over where that is more."""
    chosen = [first for first, _ in ends]
    largest = value(chosen)
    for k, (_, second) in enumerate(ends[:turned]):
        other = [*chosen[:k], second, *chosen[k + 1 :]]
        if (found := value(other)) > largest:
            largest, chosen = found, other
    return largest


def _ranked(effects: Iterable[FigureEffect]) -> list[FigureEffect]:
    """Those that matter, the largest first."""
    return sorted((each for each in effects if each.width > 0.0), key=lambda each: -each.width)


def _most_of(ranked: Sequence[FigureEffect]) -> list[str]:
    """The figure that makes more than half of the range, or the two that do; none where it takes three."""
    whole = sum(each.width for each in ranked)
    for count in (1, 2):
        if sum(each.width for each in ranked[:count]) > (0.4 + 0.1 * count) * whole:
            return [each.figure for each in ranked[:count]]
    return []


def uncertain_figures(figures: ControlFigures, machine: Machine) -> list[UncertainFigure]:
    """The figures of a control that are not exact, by what its file says or else the usual. Raises UsageError."""
    found = []
    for name, spread in spreads(figures).items():
        value = figure_of(figures, name)
        if name in LIMITS and (isinstance(spread, dict) or isinstance(value, dict)):
            usual = USUAL[figures.model].get(name, 1.0)
            by_axis = spread if isinstance(spread, dict) else dict.fromkeys(machine.joints, spread)
            for axis in by_axis:
                if axis not in machine.joints:
                    what = f"[time.uncertainty] {name}: machine '{machine.name}' has no axis {axis[:60]}"
                    raise UsageError(f"{what}; {did_you_mean(axis[:60], machine.joints)}")
            for axis, limit in limits_by_axis(figures, machine, name).items():
                factors = _factors(f"{name}.{axis}", by_axis.get(axis, usual), limit)
                found.append(UncertainFigure(name, axis, factors))
        elif isinstance(value, dict) or isinstance(spread, dict):
            raise UsageError(f"[time.uncertainty] {name}: give one factor, or both ends")
        else:
            found.append(UncertainFigure(name, "", _factors(name, spread, value)))
    return [each for each in found if each.factors[0] != each.factors[1]]


def spreads(figures: ControlFigures) -> dict[str, Spread | dict[str, Spread]]:
    """How uncertain figures of the model are, by name; those of makers' tables as `fanuc.corner_difference`.

    Raises UsageError where there is no such figure.
    """
    stated: dict[str, Spread | dict[str, Spread]] = {}
    for name, spread in figures.uncertainty.items():
        if isinstance(spread, dict) and name not in LIMITS:
            stated |= {f"{name}.{figure}": each for figure, each in spread.items()}
        else:
            stated[name] = spread
    found: dict[str, Spread | dict[str, Spread]] = {}
    for name, spread in USUAL[figures.model].items():
        value = figure_of(figures, name)
        if isinstance(spread, list) and isinstance(value, float):
            # usual ends are those of the usual figure
            spread = [min(spread[0], value), max(spread[1], value)]
        # without G64 P LinuxCNC has no tolerance, and its planner 0 keeps no jerk
        idle = {"tolerance": figures.tolerance is None, "jerk": figures.linuxcnc.planner == 0}.get(name, False)
        if figures.model != "linuxcnc" or not idle:
            found[name] = spread
    return found | stated


def figure_of(figures: ControlFigures, name: str) -> float | dict[str, float]:
    """A figure by its name, in the units of the controller's file. Raises UsageError."""
    if name == "tolerance":
        return figures.room / MILLIMETRE
    table, _, own = name.rpartition(".")
    holder = getattr(figures, table, None) if table else figures
    value = getattr(holder, own, None)
    if isinstance(value, dict) or (isinstance(value, int | float) and not isinstance(value, bool)):
        return value
    names = [*LIMITS, "tolerance", "axis_tolerance", "block_time", *USUAL.get(figures.model, {})]
    raise UsageError(f"[time.uncertainty] {name[:60]}: there is no such figure; {did_you_mean(name[:60], names)}")


def value_of(figures: ControlFigures, machine: Machine, figure: UncertainFigure) -> float:
    """The value of an uncertain figure, in the units of the controller's file."""
    if figure.axis:
        return limits_by_axis(figures, machine, figure.name)[figure.axis]
    value = figure_of(figures, figure.name)
    assert not isinstance(value, dict)
    return value


def bounds_of(figures: ControlFigures, name: str) -> Ends:
    """The least and the most that a figure may be, in the units of the controller's file."""
    table, _, own = name.rpartition(".")
    fields = msgspec.inspect.type_info(type(getattr(figures, table) if table else figures))
    assert isinstance(fields, msgspec.inspect.StructType)
    (kind,) = (each.type for each in fields.fields if each.name == own)
    kinds = kind.types if isinstance(kind, msgspec.inspect.UnionType) else (kind,)
    (number,) = (each for each in kinds if isinstance(each, msgspec.inspect.FloatType | msgspec.inspect.IntType))
    least = number.gt if number.ge is None else number.ge
    return (0.0 if least is None else float(least), math.inf if number.le is None else float(number.le))


def with_figure(figures: ControlFigures, name: str, value: float | dict[str, float]) -> ControlFigures:
    """The figures with another value of one. Raises UsageError where it is out of its bounds."""
    table, _, own = name.rpartition(".")
    entries = msgspec.to_builtins(figures)
    (entries[table] if table else entries)[own] = value
    try:
        return msgspec.convert(entries, ControlFigures)
    except msgspec.ValidationError as error:
        raise UsageError(f"[time.uncertainty] {name}: {in_short(error)}; give both ends") from None


def with_limit(figures: ControlFigures, machine: Machine, name: str, axis: str, factor: float) -> ControlFigures:
    """The figures with the acceleration or jerk of one axis times a factor."""
    limits, own = limits_by_axis(figures, machine, name), getattr(figures, name)
    # a share of the machine's limits becomes a table of all
    table = dict(own) if isinstance(own, dict) else limits
    return with_figure(figures, name, table | {axis: factor * limits[axis]})


def limits_by_axis(figures: ControlFigures, machine: Machine, name: str) -> dict[str, float]:
    """Acceleration or jerk that a control takes for the limits of axes, in the units of the controller's file."""
    limits = getattr(limits_of(machine, figures), name) / np.where(machine.is_rotary, DEGREE, MILLIMETRE)
    return dict(zip(machine.joints, limits.tolist()))


def _factors(name: str, spread: Spread, value: float) -> Ends:
    """Both ends over the figure, or the ends themselves of one that is zero."""
    if not isinstance(spread, list):
        return (1.0 / spread, spread) if value else (0.0, 0.0)
    least, most = spread
    if not least <= value <= most:
        raise UsageError(f"[time.uncertainty] {name}: the figure, {value:g}, is not between {least:g} and {most:g}")
    return (least / value, most / value) if value else (least, most)
