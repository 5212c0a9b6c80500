"""The figures of a plan that one asks for first, from the motion, its verification and plan.json."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.results.report import shell
from toolpace.results.report.words import at_most, percent

if TYPE_CHECKING:
    from toolpace.judge import Verification
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.toolpath import ToolPath

SIDES = {"outside": "only out of the part", "above": "only up along the tool"}
"""Words of tolerances that say on which side of the program the tip must be, and what they mean."""


class BendingFigures(Protocol):
    """The bending that a path compensates."""

    @property
    def largest_mm(self) -> float: ...
    @property
    def rounds(self) -> int: ...


class IterationFigures(Protocol):
    """A path that was fitted on the way."""

    @property
    def duration_s(self) -> float: ...


class ReadingFigures(Protocol):
    """Files beside the plan that its program is read with; empty where there are none."""

    @property
    def controller_file(self) -> str: ...
    @property
    def setup_file(self) -> str: ...


class PlanFigures(Protocol):
    """Keys of plan.json that a report reads; what is not known is None."""

    @property
    def program_file(self) -> str: ...
    @property
    def reading(self) -> ReadingFigures: ...

    @property
    def program(self) -> str: ...
    @property
    def machine(self) -> str: ...
    @property
    def blocks(self) -> int: ...
    @property
    def fit_s(self) -> float: ...
    @property
    def solve_s(self) -> float: ...
    @property
    def tip_deviation_mm(self) -> float | None: ...
    @property
    def tip_tolerance_mm(self) -> float | None: ...
    @property
    def tip_tolerances(self) -> str | None: ...
    @property
    def axis_deviation_deg(self) -> float | None: ...
    @property
    def axis_tolerance_deg(self) -> float | None: ...
    @property
    def tip_at_tolerance(self) -> float | None: ...
    @property
    def axis_at_tolerance(self) -> float | None: ...
    @property
    def effort(self) -> str: ...
    @property
    def rounds(self) -> Sequence[IterationFigures]: ...
    @property
    def bending(self) -> BendingFigures | None: ...
    @property
    def prices_s(self) -> Mapping[str, float]: ...


def key_figures(
    trajectory: Trajectory,
    length: float | None,
    toolpath: ToolPath | None,
    verification: Verification | None,
    figures: PlanFigures | None,
) -> str:
    """The figures one asks for first, as cards (HTML); `length` [m] is that of the tip's way, None without a tool."""
    cards = [("Time", format_time(trajectory.duration), "from rest to rest", "big")]
    if trajectory.lower_bound > 0.0 and math.isfinite(trajectory.lower_bound):
        note = "slower at most than the best on this path and mesh"
        if trajectory.continuous_bound > 0.0:
            above = at_most(trajectory.duration / trajectory.continuous_bound - 1.0)
            note += f"; {above} than any motion on this path"
        cards.append(("Gap", at_most(trajectory.gap), note, ""))
    if length is not None:
        mean = length / trajectory.duration * 60e3 if trajectory.duration > 0.0 else 0.0
        shown = f"{length:.3f} m" if length >= 1.0 else f"{length * 1e3:.1f} mm"
        cards.append(("Path length of the tip", shown, f"{mean:.0f} mm/min on average", ""))
    stops = max(len(trajectory.laws) - 1, 0)
    blocks = (figures.blocks if figures is not None else 0) or (
        toolpath.blocks or len(toolpath) if toolpath is not None else 0
    )
    if blocks:
        shown = f"{blocks:,}".replace(",", "\u202f")
        cards.append(("Blocks", shown, counted(stops, "stop"), ""))
    if trajectory.skipped:
        left_out = 1e3 * sum(each.length for each in trajectory.skipped)
        off = 1e3 * max(each.off for each in trajectory.skipped)
        cards.append(("Left out of the path", f"{left_out:.4g} mm", f"up to {off:.4g} mm off the path of the tip", ""))
    cards += _deviations(verification, figures)
    if figures is not None:
        cards += _iterations(figures, trajectory.duration)
    if figures is not None and figures.bending is not None:
        bent, rounds = figures.bending.largest_mm * 1e3, figures.bending.rounds
        note = f"at most, the path is shifted against it; {counted(rounds, 'iteration')}"
        cards.append(("Bending compensated", f"{bent:.2f} µm", note, ""))
    worst = trajectory.usage().worst
    cards.append(("Highest use of a limit", percent(worst), "at any time, of all limits", ""))
    if figures is not None:
        spent = figures.fit_s + figures.solve_s
        cards.append(("Computed in", f"{spent:.2f} s", f"{trajectory.mesh_points} mesh points", ""))
    return shell.cards(cards)


def _side(tolerances: str | None) -> str:
    """Where alone the tip may be, in the words of tolerances as plan.json has them; empty where that is both sides."""
    words = (tolerances or "").split(",")
    return next((f"; {words_of_side}" for word, words_of_side in SIDES.items() if word in words), "")


def _deviations(verification: Verification | None, figures: PlanFigures | None) -> list[tuple[str, str, str, str]]:
    """How far tip and axis are off the program, as far as it is known."""
    cards = []
    tip = _worse(
        figures.tip_deviation_mm if figures is not None else None,
        verification.tip_deviation if verification is not None else None,
        1e3,
    )
    if tip is not None:
        allowed = figures.tip_tolerance_mm if figures is not None else None
        note = f"of {allowed * 1e3:.4g} µm allowed" if allowed else "from the program"
        note += _near(figures.tip_at_tolerance if figures is not None else None)
        note += _side(figures.tip_tolerances if figures is not None else None)
        cards.append(("Tip deviation", f"{tip * 1e3:.2f} µm", note, ""))
    axis = _worse(
        figures.axis_deviation_deg if figures is not None else None,
        verification.axis_deviation if verification is not None else None,
        180.0 / math.pi,
    )
    if axis is not None:
        allowed = figures.axis_tolerance_deg if figures is not None else None
        note = f"of {allowed:.4g}° allowed" if allowed else "from the program"
        note += _near(figures.axis_at_tolerance if figures is not None else None)
        cards.append(("Axis deviation", f"{axis:.4f}°", note, ""))
    return cards


def _near(share: float | None) -> str:
    """On how much of the way a tolerance is used, where that is known."""
    return "" if share is None else f"; more than 90 % of it is used on {percent(share)} of the path"


def _iterations(figures: PlanFigures, planned: float) -> list[tuple[str, str, str, str]]:
    """The time after each iteration of path and speed, and what they save; `planned`: duration of the plan [s]."""
    if len(figures.rounds) < 2:
        return []
    first = figures.rounds[0].duration_s
    steps = " → ".join(f"{each.duration_s:.2f}" for each in figures.rounds)
    note = f"less time than the first path; effort {figures.effort}: {steps} s"
    return [("Saved by iterations", percent(max(1.0 - planned / first, 0.0)), note, "")]


def _worse(planned: float | None, judged: float | None, scale: float) -> float | None:
    """The larger of two deviations as far as they are known, in shop-floor units."""
    both = [float(planned)] if planned is not None else []
    both += [judged * scale] if judged is not None and math.isfinite(judged) else []
    return max(both) if both else None
