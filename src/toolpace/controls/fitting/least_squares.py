"""The figures of a control that a measurement tells, with the uncertainty that it leaves.

The uncertain figures x, each as the logarithm of its ratio to what is known before, over the deviation of that:
least squares: (times of the model - measured times) / their deviation, and x itself    Levenberg and Marquardt
deviation of the times <- as they are written or logged, at least what the fit leaves
covariance of x <- inverse of J'J + 1                                                     (Laplace's approximation)

So a figure of which the times tell nothing stays what it was, as uncertain as it was. Stated is the interval that holds
95 of 100. Of one time alone one figure follows: that which the range of the time is mostly from. What the uncertainty
of the others does to the time makes its own uncertain.
"""
from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import format_time
from toolpace.controls.timing.figures import ControlFigures, Spread
from toolpace.controls.timing.program_time import MODELS
from toolpace.controls.timing.uncertainty import UncertainFigure, bounds_of, uncertain_figures, value_of
from toolpace.programs.commanded import Commanded

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

ANYTHING = 1e3
"""Factor by which these may differ."""
ALONE = 50.0
"""The same of the figure that one time alone tells."""
TRIED = np.geomspace(0.02, 50.0, 12)
"""Factors of the first of them that are tried first: there may be more than one that fits nearly."""
FARTHEST = 4.0
"""Deviations by which a figure may differ from what it was."""
NORMAL = 1.96
"""Deviations to either side that hold 95 of 100."""
STEP = 0.02
"""Of the logarithm of a figure in derivatives: times of some models are counted in cycles."""
NEWS = 0.9
"""Share of its deviation before that a figure keeps at most where the measurement tells of it."""
ONE_SIDED = 0.5
"""Share of the effect of a lower acceleration that a higher one has at most where another axis always limits."""
ROUNDED = 5e-4
"""Least uncertainty that is stated, as a share: figures are written with five digits."""
WORST = 0.5
"""Misfit, or difference of the whole, over the duration from which a measurement is none of the program."""
BOUND = 1e-9
"""Share of its logarithm by which a figure stays away from its bounds, for rounding."""
ITERATIONS = 8


@dataclass(frozen=True)
class FittedFigure:
    """A figure that a measurement tells, in the units of the controller's file."""

    name: str
    """In words: "jerk of X"."""
    value: float
    least: float
    most: float
    """Ends between which it lies, in 95 of 100 cases."""
    unit: str
    """Empty where its maker's manual says it."""

    def __str__(self) -> str:
        return f"{self.name} {self.value:.4g} {self.unit}".rstrip() + f" ({self.least:.4g} to {self.most:.4g})"


@dataclass(frozen=True)
class Fit:
    """What a measurement tells of a control."""

    figures: ControlFigures
    """With the fitted ones, and their uncertainty."""
    fitted: tuple[FittedFigure, ...]
    """Those that the measurement tells of."""
    measured: float
    """The whole of the measured times [s]."""
    modelled: float
    """The same of the model with these figures [s]."""
    misfit: float
    """Root mean square of the differences, along a log or of the operations [s]."""
    doubts: tuple[str, ...] = ()
    """What tells that the measurement is not of the whole program, a sentence each."""


@dataclass(frozen=True)
class Measured:
    """Times, and how a model tells the same from the times of moves."""

    times: Floats
    deviation: Floats
    of_moves: Callable[[Floats], Floats]
    """Times of moves (n,), dwells left out, to times as measured."""
    whole: float
    """[s]"""
    exact: int = 0
    """How many of the last times are as exact as they say, whatever the fit leaves of the others."""


@dataclass(frozen=True)
class Parameter:
    figure: UncertainFigure
    deviation: float
    """Of the logarithm, before the measurement."""
    measured: bool = False
    """Whether the measurement tells it by itself, without a model."""
    least: float = -math.inf
    """Logarithm of the ratio below which it cannot be."""


def parameters_of(figures: ControlFigures, machine: Machine, free: Sequence[str]) -> list[Parameter]:
    """The figures that may change, and how far; those that are zero are left as they are."""
    found = []
    for each in uncertain_figures(figures, machine):
        least, most = each.factors
        if least > 0.0 and math.isfinite(most) and each.factors != (0.0, 0.0):
            widest = max(math.log(most), -math.log(least), ROUNDED)
            found.append(Parameter(each, (math.log(ANYTHING) if each.name in free else widest) / NORMAL))
    return found


@dataclass(frozen=True)
class _Solution:
    x: Floats
    ends: dict[int, tuple[float, float]]
    """Of the figures that the measurement tells, in deviations."""
    cost: float


class Fitting:
    """Least squares over the figures of a control."""

    def __init__(
        self, moves: Commanded, machine: Machine, start: ControlFigures, measured: Measured,
        parameters: Sequence[Parameter], before: Mapping[str, float] | None = None,
    ) -> None:  # fmt: skip
        """before: accelerations of axes before a log was looked at."""
        self.before = before or {}
        self.moves, self.machine, self.start, self.measured = moves, machine, start, measured
        self.parameters = parameters
        self.deviations = np.array([each.deviation for each in parameters])
        self.highest = np.minimum(FARTHEST, math.log(ANYTHING) / self.deviations)
        self.lowest = np.maximum(-self.highest, [each.least / each.deviation for each in parameters])
        if not len(parameters):
            raise UsageError("--fit: no figure of this control is uncertain; state how much under [time.uncertainty]")
        bounds = [bounds_of(start, each.figure.name) for each in parameters]
        values = [value_of(start, machine, each.figure) for each in parameters]
        with np.errstate(divide="ignore"):
            least, most = np.log(np.array(bounds) / np.array(values)[:, None]).T / self.deviations
        # rounding of the logarithm lets no figure out of its bounds
        self.least, self.most = least * (1.0 - BOUND), most * (1.0 - BOUND)
        """(figures,) deviations between which figures are within the bounds of a controller's file."""
        self.lowest, self.highest = np.maximum(self.lowest, self.least), np.minimum(self.highest, self.most)

    def figures(self, x: Floats) -> ControlFigures:
        figures = self.start
        within = np.clip(x, self.least, self.most)
        for each, factor in zip(self.parameters, np.exp(within * self.deviations).tolist()):
            if factor != 1.0:
                figures = each.figure.at(factor, figures, self.machine)
        return figures

    def times(self, x: Floats) -> Floats:
        """Of the model, as they were measured [s]."""
        figures = self.figures(x)
        return self.measured.of_moves(MODELS[figures.model](self.moves, self.machine, figures).times)

    def slopes(self, x: Floats) -> Floats:
        """(m, figures) of the times over x [s]."""
        columns = []
        for k, deviation in enumerate(self.deviations):
            higher, lower = x.copy(), x.copy()
            higher[k] = min(x[k] + STEP / deviation, self.most[k])
            lower[k] = max(x[k] - STEP / deviation, self.least[k])
            columns.append((self.times(higher) - self.times(lower)) / (higher[k] - lower[k]))
        return np.column_stack(columns)

    def result(self, first: str = "") -> Fit:
        """The fit to all times; of the figure `first` several are tried to begin with, else each that matters."""
        found = [self._solution(start) for start in ([self._begin(first)] if first else self._starts())]
        best = min(found, key=lambda each: each.cost)
        # of two figures one may limit, or the other: what fits as well counts as possible
        near = [each for each in found if each.cost - best.cost < NORMAL**2]
        intervals = {}
        for k in best.ends:
            ends = [each.ends.get(k, (-NORMAL, NORMAL)) for each in near]
            intervals[k] = (min(low for low, _ in ends), max(high for _, high in ends))
        narrowed = {
            k: each for k, each in intervals.items() if each != (-NORMAL, NORMAL) or self.parameters[k].measured
        }
        return self._fit(best.x, narrowed)

    def _starts(self) -> list[Floats]:
        """What was before, and the two figures that change the times most higher and lower."""
        middle = np.zeros(len(self.parameters))
        effects = np.abs(self.slopes(middle)).sum(axis=0)
        starts = [middle]
        for k in np.argsort(effects)[-2:]:
            starts += [middle + sign * np.eye(len(middle))[k] for sign in (-1.0, 1.0)]
        return starts

    def _solution(self, x: Floats) -> _Solution:
        from scipy.special import stdtrit

        scale, scales = 1.0, np.ones(len(self.measured.times))
        rough = len(scales) - self.measured.exact
        for _ in range(2):
            x = self._least(x, scales)
            off = (self.times(x) - self.measured.times) / self.measured.deviation
            slopes = self.slopes(x) / self.measured.deviation[:, None]
            weighted = slopes / scales[:, None]
            covariance = np.linalg.inv(weighted.T @ weighted + np.eye(len(x)))
            free = max(rough - float(np.sum(1.0 - np.diag(covariance))), 1.0)
            scale = max(1.0, math.sqrt(float(off[:rough] @ off[:rough]) / free))
            scales[:rough] = scale
        scales[rough:] = np.maximum(1.0, np.abs(off[rough:]))
        weighted = slopes / scales[:, None]
        covariance = np.linalg.inv(weighted.T @ weighted + np.eye(len(x)))
        within = NORMAL if scale == 1.0 else float(stdtrit(free, 0.975))
        kept = np.sqrt(np.diag(covariance))
        ends = {
            k: self._ends(x, k, within, within * float(kept[k]), scales)
            for k in range(len(x))
            if kept[k] < NEWS or self.parameters[k].measured
        }
        return _Solution(x, ends, float(off @ off) + float(x @ x))

    def _ends(self, x: Floats, k: int, within: float, half: float, scales: Floats) -> tuple[float, float]:
        """Of a figure, in deviations: where the times do not exclude what was possible before, that still is."""

        def misfit(value: float) -> float:
            changed = x.copy()
            changed[k] = value
            off = (self.times(changed) - self.measured.times) / (scales * self.measured.deviation)
            return float(off @ off)

        least = misfit(float(x[k]))
        below, above = (misfit(value) - least > within**2 for value in (-NORMAL, NORMAL))
        low = max(float(x[k]) - half if below else -NORMAL, min(float(self.lowest[k]), float(x[k])))
        return low, float(x[k]) + half if above else NORMAL

    def of_one_time(self) -> Fit:
        """The one figure that matters most, so that the model takes the measured time."""
        from scipy.optimize import brentq

        x = np.zeros(len(self.parameters))
        effects = self.slopes(x)[0]
        k = int(np.argmax(np.abs(effects)))

        def off(value: float) -> float:
            x[k] = value
            return float(self.times(x)[0] - self.measured.times[0])

        farthest = math.log(ALONE) / self.deviations[k]
        ends = np.clip([-farthest, farthest], self.least[k], self.most[k])
        # time may rise and fall again with a figure: of several values that fit, the nearest to what was before
        tried = np.unique(np.clip([0.0, *(np.log(TRIED) / self.deviations[k])], ends[0], ends[1]))
        reached = [off(value) for value in tried.tolist()]
        between = [i for i in range(len(tried) - 1) if reached[i] * reached[i + 1] <= 0.0]
        if effects[k] == 0.0 or not between:
            least, most = (end(reached) + float(self.measured.times[0]) for end in (min, max))
            raise UsageError(
                f"--fit: no {self.parameters[k].figure} makes the model take {format_time(self.measured.times[0])}: it "
                f"takes {format_time(least)} to {format_time(most)}; is it the time of this program, without waiting "
                "for people? Does the set-up sheet tell what tool changes take?"
            )
        i = min(between, key=lambda i: max(abs(float(tried[i])), abs(float(tried[i + 1]))))
        x[k] = float(brentq(off, float(tried[i]), float(tried[i + 1]), xtol=1e-4))
        slopes = self.slopes(x)[0]
        others = float(np.sum(slopes**2) - slopes[k] ** 2)
        deviation = math.sqrt(others + float(self.measured.deviation[0]) ** 2)
        # where the time is counted in cycles it may not change with the figure: then all that was tried is possible
        half = NORMAL * deviation / abs(float(slopes[k])) if slopes[k] else math.inf
        low, high = np.clip([x[k] - half, x[k] + half], ends[0], ends[1]).tolist()
        return self._fit(x, {k: (low, high)})

    def _begin(self, first: str) -> Floats:
        x = np.zeros(len(self.parameters))
        of_first = [k for k, each in enumerate(self.parameters) if each.figure.name == first]
        if not of_first:
            return x
        starts = []
        for factor in TRIED:
            x[of_first] = math.log(factor) / self.deviations[of_first]
            starts.append(x.copy())
        return min(starts, key=lambda start: float(np.sum((self.times(start) - self.measured.times) ** 2)))

    def _least(self, x: Floats, scales: Floats) -> Floats:
        from scipy.optimize import least_squares

        deviation = scales * self.measured.deviation

        def residuals(x: Floats) -> Floats:
            return np.concatenate([(self.times(x) - self.measured.times) / deviation, x])

        def slopes(x: Floats) -> Floats:
            return np.vstack([self.slopes(x) / deviation[:, None], np.eye(len(x))])

        found = least_squares(
            residuals, np.clip(x, self.lowest, self.highest), jac=slopes, bounds=(self.lowest, self.highest),
            xtol=1e-4, ftol=1e-6, max_nfev=ITERATIONS,
        )  # fmt: skip
        return np.asarray(found.x)

    def _fit(self, x: Floats, ends_of: dict[int, tuple[float, float]]) -> Fit:
        """With the figures of which the measurement tells, and the ends between which they lie, in deviations."""
        times = self.times(x)
        rough = len(times) - self.measured.exact
        off, whole = (times - self.measured.times)[:rough], self.measured.whole
        misfit = float(np.sqrt(np.mean(np.cumsum(off) ** 2)))
        worst = max(misfit, abs(float(off.sum())))
        if not worst <= WORST * whole:
            raise UsageError(
                f"measured are {whole:.4g} s, and the model is {worst:.4g} s off on the way: that is not measured of "
                "this program on this machine, or columns are exchanged"
            )
        figures, fitted = self.figures(x), []
        uncertainty: dict[str, Spread | dict[str, Spread]] = dict(self.start.uncertainty)
        for k, (low, high) in ends_of.items():
            each = self.parameters[k].figure
            value = value_of(figures, self.machine, each)
            down, up = (max(abs(end - x[k]) * self.deviations[k], ROUNDED) for end in (low, high))
            least, most = bounds_of(figures, each.name)
            ends = [max(value * math.exp(-down), least), min(max(value * math.exp(up), self._upper_end(x, k)), most)]
            fitted.append(FittedFigure(str(each), value, ends[0], ends[1], each.unit(self.machine)))
            factors = [value / ends[0], ends[1] / value]
            even = abs(math.log(factors[1] / factors[0])) < ROUNDED and least < value / max(factors)
            _state(uncertainty, each, _rounded(max(factors)) if even else [_rounded(end) for end in ends])
        figures = msgspec.structs.replace(figures, uncertainty=uncertainty)
        return Fit(figures, tuple(fitted), whole, whole + float(off.sum()), misfit)

    def _upper_end(self, x: Floats, k: int) -> float:
        """What the acceleration of an axis may be at most, where another axis always limits; else 0."""
        figure = self.parameters[k].figure
        if figure.name != "acceleration" or figure.axis not in self.before:
            return 0.0
        step = np.zeros(len(x))
        step[k] = STEP / self.deviations[k]
        here = self.times(x)
        more, less = (float(np.abs(self.times(x + way * step) - here).sum()) for way in (1.0, -1.0))
        return self.before[figure.axis] * figure.factors[1] if more <= ONE_SIDED * less else 0.0


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")


def _state(uncertainty: dict[str, Spread | dict[str, Spread]], figure: UncertainFigure, spread: Spread) -> None:
    """Enter the uncertainty of a figure as the controller's file has it."""
    table, _, own = figure.name.rpartition(".")
    if not table and not figure.axis:
        uncertainty[own] = spread
        return
    key, entry = (figure.name, figure.axis) if figure.axis else (table, own)
    before = uncertainty.get(key)
    uncertainty[key] = (before if isinstance(before, dict) else {}) | {entry: spread}
