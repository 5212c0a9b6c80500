"""Smooth paths of tool tip and tool axis in the workpiece frame."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.units import FASTEST_FEED, METRES_PER_SECOND, RADIANS, ask_about_unit, refuse_other_unit
from toolpace.common.value_objects import counted, one_line
from toolpace.machine.machine import Machine
from toolpace.path.run import PathRun
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

if TYPE_CHECKING:
    from toolpace.path.fit.speed_weights import SpeedWeights


MOST_SWEPT = 4.0 * math.pi
"""Of an arc [rad]: two turns."""


@dataclass(frozen=True, eq=False, repr=False)
class Path:
    """Runs from stop to stop, each with a parameter of its own: that of a fitted run begins at 0.

    Were it counted from the start of the program, 20 m on a last digit of it would be 4e-15 m, and turn a rotary joint
    that passes close to its pole by as much as its jerk shows.
    """

    runs: tuple[PathRun, ...]
    tip_deviation: float = 0.0
    """Largest distance of the tip from the program, both ways and between the points [m]."""
    axis_deviation: float = 0.0
    """Largest angle of the tool axis from that of the program [rad]."""
    fit_seconds: float = 0.0
    first_dwell: float = 0.0
    """Time to wait before the first run [s]."""

    def __repr__(self) -> str:
        fitted = self.fit_seconds > 0.0
        return one_line(
            self,
            counted(len(self.runs), "run"),
            counted(sum(len(run.block) for run in self.runs), "block"),
            f"tip within {self.tip_deviation * 1e6:.3g} um" if fitted else "",
            f"axis within {math.degrees(self.axis_deviation):.3g} deg" if fitted else "",
        )

    @classmethod
    def fit(
        cls,
        toolpath: ToolPath,
        tip_tolerance: float | Tolerances = 10e-6,
        axis_tolerance: float | Tolerances = 1e-3,
        machine: Machine | None = None,
        progress: Callable[[float], None] | None = None,
        speed_weights: Sequence[SpeedWeights] | None = None,
        hastes: Sequence[SpeedWeights] | None = None,
    ) -> Path:
        """The smoothest curve within the tolerances [m], [rad] of a tool path, stopping where it stops.

        A tolerance is a number, or `Tolerances` where it differs by operation, tool or block: each block's own holds.

        With a machine the curve is one of tip and rotary joints, else of tip and tool axis. `progress` is told the
        share done. `speed_weights`, one a run, say where a motion is fast: there the curve is smoother, and less so
        where it is slow; see `plan_program`, which finds them. PathError where nothing moves or no curve fits.
        """
        from toolpace.machine.machine import check_machine
        from toolpace.path.fit.tolerance_tube import TubeFit
        from toolpace.programs.toolpath import check_toolpath

        if hastes is not None:
            warnings.warn(
                "Path.fit: hastes= is called speed_weights= now; the old name goes with the next release",
                DeprecationWarning, stacklevel=2,
            )  # fmt: skip
            speed_weights = hastes
        if machine is not None:
            check_machine(machine, "fit", "a Machine, or None")
        check_toolpath(toolpath, "fit")
        begin = time.perf_counter()
        fit = TubeFit(toolpath, tip_tolerance, axis_tolerance, machine)
        runs, tip, axis, wait = fit.runs(progress, speed_weights)
        return cls(runs, tip, axis, time.perf_counter() - begin, wait)

    @classmethod
    def from_callable(
        cls,
        f: Callable[[Floats, int], tuple[Floats, Floats]],
        s0: float = 0.0,
        s1: float = 1.0,
        feed: float = math.inf,
    ) -> Path:
        """A path whose derivatives f(s (n,), order 0 to 3) -> (tip (n, 3) [m], unit axis (n, 3)) knows.

        They are held against differences at places along the path: PathError, with the place, where one is not the
        derivative of the order below.
        """
        from toolpace.path.exact import checked_run

        refuse_other_unit(feed, FASTEST_FEED, "path: feed", METRES_PER_SECOND)
        return cls((checked_run(f, s0, s1, feed),))

    @classmethod
    def arc(
        cls,
        centre: Floats,
        start: Floats,
        normal: Floats,
        sweep: float,
        lean: float = 0.0,
        feed: float = math.inf,
    ) -> Path:
        """A circular arc [m], anticlockwise about `normal` by `sweep` [rad], over its length.

        The tool axis stays in the plane, turned from the outward normal by `lean` [rad] towards the travel.
        """
        from toolpace.path.exact import arc_run

        refuse_other_unit(feed, FASTEST_FEED, "path: feed", METRES_PER_SECOND)
        ask_about_unit(sweep, MOST_SWEPT, "arc: sweep", RADIANS)
        refuse_other_unit(lean, MOST_SWEPT, "arc: lean", RADIANS)
        return cls((arc_run(centre, start, normal, sweep, lean, feed),))

    @classmethod
    def paper_arc(cls, feed: float = 0.03) -> Path:
        """The quarter circle of Wu, Li, Liu and Perez (ACC 2009), section III, in the plane x = y, radius 0.1 m.

        Centre the origin, from (0, 0, 0.1) down to (0.0707, 0.0707, 0): the printed centre contradicts the printed
        projection. The paper leaves the tool axis open; here it leans 45 degrees back from the outward normal.
        """
        normal = np.array([-1.0, 1.0, 0.0]) / math.sqrt(2.0)
        return cls.arc(np.zeros(3), np.array([0.0, 0.0, 0.1]), normal, 0.5 * math.pi, -0.25 * math.pi, feed)

    @classmethod
    def from_bspline(
        cls, knots: Floats, tip: Floats, axis_point: Floats, degree: int = 3, feed: float = math.inf
    ) -> Path:
        """Two B-splines [m] over one parameter: the tip, and a second point on the tool axis towards the spindle."""
        from toolpace.path.exact import bspline_run

        refuse_other_unit(feed, FASTEST_FEED, "path: feed", METRES_PER_SECOND)
        return cls((bspline_run(knots, tip, axis_point, degree, feed),))
