"""By what the cut of a program sets the speed of its plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from toolpace.common.errors import UsageError, did_you_mean

if TYPE_CHECKING:
    from toolpace.cutting.feeds.limited_plan import CutLimitedPlan
    from toolpace.cutting.feeds.limits import CutLimits
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.jobs import TimedSteps
    from toolpace.judge import Verification
    from toolpace.judge.cut import Bent
    from toolpace.machine.cutting_tool import CuttingTool
    from toolpace.machine.machine import Machine
    from toolpace.motion.setpoints import SetPointSource
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.tolerances import Tolerances
    from toolpace.programs.toolpath import ToolPath
    from toolpace.results.write.cut_limits import CutLimitsRecord


LIMIT_UNITS = {
    "chip": ("mm", 1e-3), "feed_per_tooth": ("mm", 1e-3), "removal_rate": ("mm3/s", 1e-9), "force": ("N", 1.0),
    "torque": ("Nm", 1.0), "power": ("W", 1.0), "moment": ("Nm", 1.0), "stress": ("MPa", 1e6),
    "deflection": ("um", 1e-6), "surface_deflection": ("um", 1e-6), "compensated_deflection": ("um", 1e-6),
    "feed_marks": ("um", 1e-6),
}  # fmt: skip
"""Limits of the cut, and the unit in which each is given."""


class Planning(Protocol):
    """What is asked of a plan, as a job tells it."""

    @property
    def machine(self) -> Machine:
        """That it is for."""

    @property
    def options(self) -> ReadOptions:
        """How the program is read; its set-up sheet."""

    @property
    def tip_tolerance(self) -> float | Tolerances:
        """[m]"""

    @property
    def axis_tolerance(self) -> float | Tolerances:
        """[rad]"""

    @property
    def effort(self) -> str:
        """For a fast path."""

    @property
    def planner(self) -> str:
        """Its name."""

    @property
    def tool(self) -> CuttingTool | None:
        """Whose bending is compensated."""


@dataclass(frozen=True)
class CutOptions:
    """What is asked of a plan within its cut."""

    rules: FeedRules
    margin: float = 0.0
    """How far before and behind a place what its cut allows holds [m]."""
    resolution: float | None = None
    """Size of a cell of the stock [m]; None: the finest that `memory` has room for."""
    memory: float = 1e9
    """Most that the stock takes [bytes]."""
    material: str = ""
    """Name or file of what `rules` has the coefficients of."""

    def plan(self, job: Planning, steps: TimedSteps, toolpath: ToolPath, name: str) -> CutLimitedPlan:
        """The plan of a program of this name; what teaches does so at the speeds that its control reaches. Raises
        ToolpaceError."""
        from toolpace.controls.timing.program_time import figures_for
        from toolpace.controls.timing.speeds import ControlSpeeds
        from toolpace.cutting.feeds.limited_plan import plan_within_cut
        from toolpace.path.axis_path import check_travel
        from toolpace.planning.program_plan import effort_for

        with steps.step("planning within the cut") as step:
            learns = self.rules.way == "learned"
            figures = figures_for(job.options, None)
            reached = ControlSpeeds.of(toolpath, job.machine, figures).mean if learns else None
            rules = replace(self.rules.for_machine(job.machine), spindle=job.options.setup.spindle)
            found = plan_within_cut(
                toolpath, job.machine, job.options.setup, rules, job.tip_tolerance, job.axis_tolerance,
                effort=effort_for(job.effort, job.planner), planner=job.planner, margin=self.margin,
                resolution=self.resolution, memory=self.memory, reached=reached, progress=step,
            )  # fmt: skip
            check_travel(found.plan.trajectory.axis_path, name)
            step.note = f"{found.plan.trajectory.mesh_points} mesh points, {found.extent}"
        for note in found.feeds.notes:
            steps.say(note)
        for over in (each for each in found.feeds.overloads if each.always):
            steps.say(
                f"line {over.line}, tool {over.tool}: however slow, the load is {over.share:.3g} times what "
                f"{over.limit} allows; the program's feed stays"
            )
        return found

    def verified(
        self, job: Planning, steps: TimedSteps, found: Verification, points: SetPointSource, toolpath: ToolPath,
        fed: ToolPath, part: tuple[CutLimitsRecord, bytes],
    ) -> Verification:  # fmt: skip
        """The judge's word, with that on the cut of the set-points along the program; fed: with the feeds that the cut
        allows."""
        from toolpace.motion.setpoints import in_memory
        from toolpace.results import write

        with steps.step("verifying the cut"):
            checks = write.judged_cut(
                part[0], write.cut_arrays(part[1]), in_memory(points), toolpath, job.options.setup, job.machine,
                bent=bent_tool(job, fed),
            )  # fmt: skip
        return replace(found, checks=(*found.checks, *checks))


def bent_tool(job: Planning, fed: ToolPath) -> Bent | None:
    """What the judge is told of a tool that bends; None where it is stiff."""
    from toolpace.judge.cut import Bent
    from toolpace.programs.tolerances import Tolerances

    if job.tool is None:
        return None
    tip, axis = (Tolerances.of(getattr(job, name), name) for name in ("tip_tolerance", "axis_tolerance"))
    return Bent(job.tool, job.machine, fed, tip, axis)


def cut_limits(words: Sequence[str]) -> dict[str, CutLimits]:
    """Limits by tool, from words such as "force=400N" and "3:chip=0.1mm". Raises UsageError."""
    from toolpace.cutting.feeds.limits import CutLimits

    found: dict[str, dict[str, float]] = {}
    for word in words:
        tool, _, rest = word.rpartition(":")
        name, _, value = rest.partition("=")
        if name not in LIMIT_UNITS:
            raise UsageError(f"--limit {word[:60]}: {name[:40]!r} is no limit; {did_you_mean(name, LIMIT_UNITS)}")
        unit, scale = LIMIT_UNITS[name]
        try:
            figure = float(value.strip().removesuffix(unit)) * scale
        except ValueError:
            raise UsageError(f"--limit {word[:60]}: give {name} in {unit}, like {name}=20{unit}") from None
        if name in found.setdefault(tool, {}):
            raise UsageError(f"--limit {word[:60]}: {name} is given twice")
        found[tool][name] = figure
    return {tool: CutLimits(**limits) for tool, limits in found.items()}
