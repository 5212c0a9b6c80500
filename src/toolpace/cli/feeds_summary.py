"""What is printed of a program with new feeds: times, spindle speeds, loads, and what was left."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from toolpace.cli.console import cells, new_table
from toolpace.common.errors import printable
from toolpace.common.units import format_figure, format_time
from toolpace.common.value_objects import counted
from toolpace.cutting.feeds.teaching import by_line

if TYPE_CHECKING:
    from toolpace.controls.timing.program_time import ProgramTime
    from toolpace.jobs.feeds import NewFeeds

SHOWN = 8
"""Teachers, overloads and lines that are listed."""


def show_feeds(console: Console, found: NewFeeds) -> None:
    """Times before and after, by operation, and what was left."""
    saved = 1.0 - found.after.total / found.before.total if found.before.total > 0.0 else 0.0
    console.print()
    for note in found.plan.notes:
        console.print(Text(printable(note)), soft_wrap=True)
    console.print(
        f"{counted(found.written.changed, 'block')} with another feed, {found.written.divided} divided; by the model "
        f"{found.model} {_with_range(found.before)} becomes {_with_range(found.after)}, {_less(saved)}",
        soft_wrap=True,
    )
    table = new_table(["operation", "tool", "before", "after", "less"], left=("operation", "tool"))
    for old, new in zip(found.before.parts, found.after.parts):
        less = 1.0 - new.time / old.time if old.time > 0.0 else 0.0
        times = format_time(old.time), format_time(new.time)
        words = [old.name or "-", old.tool or "-", *times, f"{round(100.0 * less, 1) + 0.0:.1f} %"]
        table.add_row(*cells(words))
    console.print(table)
    _show_spindle(console, found)
    _show_loads(console, found)


def _show_spindle(console: Console, found: NewFeeds) -> None:
    """Speeds before and after, with the surface speed where the tool cuts the widest, and cuts that chatter."""
    speeds = [each for each in found.spindle if not math.isnan(each.before)]
    if not speeds:
        return
    words = ["operation", "tool", "spindle", "after", "cuts at", "surface", "depth", "stable", "why"]
    table = new_table(words, left=("operation", "tool", "why"))
    for each in speeds:
        surface = 60.0 * math.pi * each.diameter * each.after
        table.add_row(
            *cells([
                each.name or "-", each.tool or "-", f"{60.0 * each.before:.0f} rpm", f"{60.0 * each.after:.0f} rpm",
                f"{1e3 * each.diameter:.3g} mm", f"{surface:.0f} m/min", f"{1e3 * each.depth:.3g} mm",
                "-" if math.isnan(each.stable_depth) else f"{1e3 * each.stable_depth:.3g} mm", each.reason,
            ])
        )  # fmt: skip
    console.print(table)
    for each in speeds:
        if each.chatters:
            console.print(
                f"line {each.line}, tool {printable(each.tool)}: the cut is {1e3 * each.depth:.3g} mm deep, and at "
                f"{60.0 * each.after:.0f} rpm its stability chart has {1e3 * each.stable_depth:.3g} mm: it may chatter",
                soft_wrap=True,
            )


def _show_loads(console: Console, found: NewFeeds) -> None:
    for sentence in found.written.told(SHOWN):
        console.print(sentence, soft_wrap=True)
    scales = {"chip": ("chip", 1e3, "mm"), "removal_rate": ("removal", 6e7, "cm3/min"), "force": ("force", 1.0, "N")}
    scales |= {"torque": ("torque", 1.0, "Nm"), "power": ("power", 1.0, "W"), "deflection": ("deflection", 1e6, "um")}
    if found.largest:
        table = new_table(["tool", "largest", "before", "after"], left=("tool", "largest"))
        for load in found.largest:
            name, scale, unit = scales[load.kind]
            words = [f"{format_figure(scale * each)} {unit}" for each in (load.before, load.after)]
            table.add_row(*cells([load.tool or "-", name, *words]))
        console.print(table)
    for kept in found.plan.kept:
        console.print(kept.told(SHOWN), soft_wrap=True)
    for teacher in (listed := by_line(found.plan.teachers))[:SHOWN]:
        where = f"{printable(teacher.program)}, " * bool(teacher.program) + f"line {teacher.line}"
        console.print(
            f"teacher: {where}, tool {printable(teacher.tool)}: chip {1e3 * teacher.chip:.3g} mm, "
            f"area {1e6 * teacher.area:.3g} mm2, edge {1e3 * teacher.edge:.3g} mm, for {format_time(teacher.seconds)}",
            soft_wrap=True,
        )
    if (more := len(listed) - SHOWN) > 0:
        console.print(f"and {more} more teachers (--json lists them)")
    for over in found.plan.overloads[:SHOWN]:
        what = f"what {over.limit} allows"
        if over.always:
            told = f"however slow, the load is {over.share:.3g} times {what}; the feed stays"
        else:
            told = f"the program's feed is {over.share:.3g} times {what}"
        console.print(f"line {over.line}, tool {printable(over.tool)}: {told}", soft_wrap=True)


def _less(share: float) -> str:
    """A share of the time that is saved, or added."""
    percent = round(100.0 * share, 1)
    return f"{abs(percent):.1f} % {'more' if percent < 0.0 else 'less'}"


def _with_range(time: ProgramTime) -> str:
    if time.range is None or not time.range.most > time.range.least:
        return format_time(time.total)
    return f"{format_time(time.total)} ({format_time(time.range.least)} to {format_time(time.range.most)})"
