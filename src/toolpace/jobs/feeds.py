"""A program with the feeds that its cut allows, and what its control makes of them.

plan the program, and cut the stock along the motion
the speed that its control reaches in each block      by its model
speeds of the spindle, where they may change          OperationSpeed
feeds by air, teachers or limits                      FeedPlan
written into the program, and read back               what gains nothing on the control is left out
the time before and after                             by the control's model, with its range
the largest loads before and after                    at the speeds that the control reaches
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from toolpace.jobs import TimedSteps
from toolpace.jobs.cut import CutRequest, ProgramCut, cut_program

if TYPE_CHECKING:
    from toolpace.common.arrays import Floats
    from toolpace.controls.export.cut_feeds import FeedProgram
    from toolpace.controls.timing.figures import ControlFigures
    from toolpace.controls.timing.program_time import ProgramTime
    from toolpace.cutting.feeds.feed_plan import FeedPlan
    from toolpace.cutting.feeds.largest_loads import LargestLoad
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.cutting.feeds.spindle_speeds import OperationSpeed
    from toolpace.cutting.simulation.simulate import CutSimulation
    from toolpace.programs.reading import ReadOptions, Source
    from toolpace.programs.tool_figures import ToolFigures
    from toolpace.programs.toolpath import ToolPath


class Reached(NamedTuple):
    """Of each stretch of a plan of feeds, (n,) the highest speed that the control reaches on the way to each station,
    by its model [m/s]."""

    before: tuple[Floats, ...]
    after: tuple[Floats, ...]


@dataclass(frozen=True)
class NewFeeds:
    """What was made of a program."""

    program: str
    controller: str
    """Empty for cutter-location data."""
    model: str
    cut: ProgramCut
    """Of the program as it was."""
    rules: FeedRules
    plan: FeedPlan
    written: FeedProgram
    before: ProgramTime
    after: ProgramTime
    reached: Reached
    turned: ToolPath
    """The program as it was, with the spindle speeds after."""
    largest: tuple[LargestLoad, ...]
    """By tool and kind, at the speeds reached; of tools whose teeth and spindle speed are known."""
    spindle: tuple[OperationSpeed, ...] = ()
    """Of each operation; empty where no speed may change and no tool has a stability chart."""

    @property
    def simulation(self) -> CutSimulation:
        """What the program as it was cuts."""
        return self.cut.simulation


def new_feeds(
    program: str, request: CutRequest, rules: FeedRules, divide: bool, steps: TimedSteps, turns: bool = False
) -> NewFeeds:
    """New feeds of one program; turns: with other spindle speeds too, of those that the tool table allows. Raises
    ToolpaceError."""
    from toolpace.controls.export.cut_feeds import with_cut_feeds
    from toolpace.controls.export.spindle_words import SpindleWords
    from toolpace.controls.timing.program_time import figures_for
    from toolpace.controls.timing.speeds import ControlSpeeds
    from toolpace.cutting.feeds.feed_moves import FeedMoves, check_tools
    from toolpace.cutting.feeds.feed_plan import plan_feeds
    from toolpace.cutting.feeds.largest_loads import largest_loads
    from toolpace.cutting.feeds.spindle_speeds import spindle_speeds
    from toolpace.programs.reading import Source
    from toolpace.programs.reading.languages import with_controller

    source = Source.load(program)
    options, found = with_controller(source, request.dialect, request.options)
    figures = figures_for(options, None)
    rules = replace(rules.for_machine(request.machine), spindle=options.setup.spindle)

    def tools_of(toolpath: ToolPath) -> list[ToolFigures | None]:
        return [options.setup.figures_of(each.tool, each.figures) for each in toolpath.operations]

    def check(toolpath: ToolPath) -> None:
        rules.check(toolpath)
        if options.setup.workpiece.stock or toolpath.workpiece.stock:
            # on a guessed stock no feed is raised, and what is missing is told with the feeds as they are
            check_tools(toolpath, tools_of(toolpath), rules)

    cut = cut_program(program, request, steps, None, lambda operation, stock: None, check)
    with steps.step("time before"):
        before = control_time(source, request, options, figures)
        speeds_before = ControlSpeeds.of(cut.toolpath, request.machine, figures)
    tools = tools_of(cut.toolpath)
    text, toolpath = source, cut.toolpath
    speeds: tuple[OperationSpeed, ...] = ()
    if turns or any(each is not None and each.stability is not None for each in tools):
        with steps.step("spindle speeds") as step:
            words = SpindleWords.of(source, request.machine, request.dialect, options, toolpath)
            speeds = spindle_speeds(cut.simulation, toolpath, tools, rules, words.together() if turns else ())
            text, toolpath = words.with_ratios([each.ratio for each in speeds])
            step.note = f"{sum(each.ratio != 1.0 for each in speeds)} operations with another speed"
    with steps.step("feeds") as step:
        ratio = [each.ratio for each in speeds]
        plan = plan_feeds(cut.simulation, cut.toolpath, tools, rules, speeds_before.mean, ratio)
        written = with_cut_feeds(
            text, request.machine, request.dialect, options, toolpath, plan, divide,
            lambda path: ControlSpeeds.of(path, request.machine, figures).times,
        )  # fmt: skip
        step.note = f"{written.changed} blocks with another feed"
    with steps.step("time after"):
        after = control_time(Source.from_bytes(written.data, source.name), request, options, figures)
        speeds_after = ControlSpeeds.of(written.toolpath, request.machine, figures)
    with steps.step("loads"):
        old = FeedMoves.of(cut.simulation, cut.toolpath, tools, rules, None)
        new = FeedMoves.of(cut.simulation, cut.toolpath, tools, rules, None, ratio) if len(ratio) else old
        reached = Reached(
            tuple(speeds_before.highest[each.stations.point] for each in old.stretches),
            tuple(speeds_after.highest[written.points_at(toolpath, each.x)] for each in plan.places),
        )
        largest = largest_loads(old, new, *reached)
    name = found.controller.name if found.controller is not None else ""
    return NewFeeds(
        program, name, figures.model, cut, rules, plan, written, before, after, reached, toolpath, largest, speeds
    )


def control_time(
    source: Source, request: CutRequest, options: ReadOptions, figures: ControlFigures
) -> ProgramTime:
    """What the control takes for a program, with its range; of a control that has no model what its feeds come to."""
    from toolpace.controls.timing.program_time import moves_of, time_of_moves, with_range

    moves = moves_of(source, request.machine, options, request.feed, request.dialect)
    time = time_of_moves(moves, request.machine, figures, options.setup.tool_change)
    return with_range(time, moves, request.machine, figures)


def feeds_record(found: NewFeeds, machine: str) -> dict[str, object]:
    """What `feeds --json` prints of a program."""
    from toolpace.cutting.feeds.teaching import by_line

    scales = {"chip": ("chip_mm", 1e3), "removal_rate": ("removal_mm3_s", 1e9), "force": ("force_N", 1.0)}
    scales |= {"torque": ("torque_Nm", 1.0), "power": ("power_W", 1.0), "deflection": ("deflection_mm", 1e3)}
    largest: dict[str, dict[str, Mapping[str, float]]] = {}
    for load in found.largest:
        key, scale = scales[load.kind]
        largest.setdefault(load.tool, {})[key] = {"before": scale * load.before, "after": scale * load.after}
    return {
        "program": found.program,
        "machine": machine,
        "controller": found.controller,
        "model": found.model,
        "guessed_stock": found.simulation.guessed,
        "before_s": found.before.total,
        "after_s": found.after.total,
        "before_range_s": _range(found.before),
        "after_range_s": _range(found.after),
        "operations": [
            {"name": old.name, "tool": old.tool, "before_s": old.time, "after_s": new.time}
            for old, new in zip(found.before.parts, found.after.parts)
        ],
        "blocks_changed": found.written.changed,
        "blocks_divided": found.written.divided,
        "lines_above": list(found.written.above),
        "lines_below": list(found.written.below),
        "missed_s": found.written.missed,
        "spindle": [
            {
                "name": each.name, "tool": each.tool, "before_rpm": 60.0 * each.before, "after_rpm": 60.0 * each.after,
                "cutting_diameter_mm": 1e3 * each.diameter, "depth_mm": 1e3 * each.depth,
                "stable_depth_mm": None if math.isnan(each.stable_depth) else 1e3 * each.stable_depth,
                "line": each.line, "reason": each.reason,
            }
            for each in found.spindle if not math.isnan(each.before)
        ],
        "largest": largest,
        "teachers": [
            {
                "line": each.line, "operation": each.operation, "tool": each.tool,
                "chip_mm": 1e3 * each.chip, "area_mm2": 1e6 * each.area, "edge_mm": 1e3 * each.edge,
                "duration_s": each.seconds, "from": each.program,
            }
            for each in by_line(found.plan.teachers)
        ],
        "overloads": [
            {"line": each.line, "tool": each.tool, "limit": each.limit, "share": each.share, "always": each.always}
            for each in found.plan.overloads
        ],
        "kept": [
            {"reason": each.reason, "duration_s": each.seconds, "lines": [list(part) for part in each.lines]}
            for each in found.plan.kept
        ],
        "notes": list(found.plan.notes),
    }  # fmt: skip


def _range(time: ProgramTime) -> list[float] | None:
    return None if time.range is None else [time.range.least, time.range.most]
