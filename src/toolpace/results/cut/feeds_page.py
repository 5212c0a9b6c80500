"""The page of new feeds: the motion with feed and loads before and after, and the times by operation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Protocol

from toolpace.common.arrays import Floats
from toolpace.common.errors import printable
from toolpace.common.units import format_figure, format_time
from toolpace.cutting.feeds.teaching import by_line
from toolpace.motion.sampling import Sampling
from toolpace.results.cut.folder import ProgramCut
from toolpace.results.cut.page import TIME_STEP
from toolpace.results.report import shell
from toolpace.results.report.charts import Curves
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.page import PLAYER, units_of
from toolpace.results.report.player_data import motion_data, page_json, workpiece_data
from toolpace.results.workpiece.feed_tracks import KINDS, feed_tracks
from toolpace.results.workpiece.tracks import CutTracks
from toolpace.results.workpiece.view import view_of_cut

if TYPE_CHECKING:
    from toolpace.cutting.feeds.feed_plan import FeedPlan
    from toolpace.cutting.feeds.largest_loads import LargestLoad
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.cutting.feeds.spindle_speeds import OperationSpeed
    from toolpace.programs.toolpath import ToolPath

LISTED = 40
"""Teachers, and places above a limit, that are listed."""
LOADS = {
    "chip": ("thickest chip", 1e6, "µm"), "removal_rate": ("removal rate", 60e6, "cm³/min"),
    "force": ("cutting force", 1.0, "N"), "torque": ("torque", 1.0, "N m"), "power": ("power", 1.0, "W"),
    "deflection": ("deflection of the tip", 1e6, "µm"),
}  # fmt: skip


class PartTime(Protocol):
    """The time of an operation on a control."""

    @property
    def name(self) -> str: ...
    @property
    def tool(self) -> str: ...
    @property
    def time(self) -> float: ...


class TimeRange(Protocol):
    """Between which times a total is [s]."""

    @property
    def least(self) -> float: ...
    @property
    def most(self) -> float: ...


class ProgramTime(Protocol):
    """The time of a program on a control [s]."""

    @property
    def total(self) -> float: ...
    @property
    def parts(self) -> tuple[PartTime, ...]: ...
    @property
    def range(self) -> TimeRange | None: ...


class FeedProgram(Protocol):
    """A program with new feeds: blocks that are changed and divided, lines that go faster than allowed."""

    @property
    def changed(self) -> int: ...
    @property
    def divided(self) -> int: ...
    @property
    def above(self) -> tuple[int, ...]: ...
    def told(self, most: int) -> list[str]: ...


class NewFeeds(Protocol):
    """What was made of a program."""

    @property
    def cut(self) -> ProgramCut: ...
    @property
    def rules(self) -> FeedRules: ...
    @property
    def model(self) -> str: ...
    @property
    def plan(self) -> FeedPlan: ...
    @property
    def written(self) -> FeedProgram: ...
    @property
    def before(self) -> ProgramTime: ...
    @property
    def after(self) -> ProgramTime: ...
    @property
    def reached(self) -> tuple[Sequence[Floats], Sequence[Floats]]: ...
    @property
    def largest(self) -> tuple[LargestLoad, ...]: ...
    @property
    def turned(self) -> ToolPath: ...
    @property
    def spindle(self) -> tuple[OperationSpeed, ...]: ...


def feeds_page(found: NewFeeds, machine: str) -> str:
    """The page as HTML; it opens without a network. The motion is that of the program as it was."""
    cut, plan = found.cut, found.plan
    duration = float(cut.trajectory.duration)
    tracks = feed_tracks(plan, cut.simulation, cut.toolpath, duration, found.rules, found.reached, found.turned)
    view = view_of_cut(cut.simulation, cut.trajectory, cut.toolpath, cut.setup, tracks=tracks)
    less = saved(found.before.total, found.after.total)
    badge = f"{100.0 * abs(less):.1f} % {'less' if less >= 0.0 else 'more'} time"
    fields = {
        "program": escape(printable(cut.program)),
        "machine": escape(printable(machine)),
        "badge": f'<span class="badge {"good" if less > 0.0 else "quiet"}">{badge}</span>',
        "cards": _cards(found),
        "motion": shell.motion_section(duration, _legend(tracks)),
        "model": escape(found.model),
        "operations": "\n".join(_operations(found)),
        "loads": _loads(found.largest),
        "notes": _notes(found),
    }
    points = Sampling(cut.trajectory, TIME_STEP, on_grid=False)
    units = units_of(cut.trajectory.axis_path.machine, points.joints)
    curves = Curves.of(points, cut.trajectory.limits, units, cut.toolpath)
    arrays = PackedArrays()
    data = motion_data(cut.trajectory, points, cut.toolpath, curves.extremes(), cut.text, arrays)
    data |= workpiece_data(view, arrays)
    page = page_json(data, arrays)
    title = printable(f"Feeds of {cut.program}")
    return shell.whole_page(__package__, "feeds_page", title, fields, page, PLAYER)


def saved(before: float, after: float) -> float:
    """Share of the time."""
    return 1.0 - after / before if before > 0.0 else 0.0


def _cards(found: NewFeeds) -> str:
    gained = found.before.total - found.after.total
    above = len(found.written.above)
    figures = [
        ("Before", format_time(found.before.total), f"by the model {found.model}{_range(found.before)}", ""),
        ("After", format_time(found.after.total), f"by the model {found.model}{_range(found.after)}", "big"),
        ("Saved" if gained >= 0.0 else "Slower by", format_time(abs(gained)), "", ""),
        ("Blocks changed", str(found.written.changed), f"{found.written.divided} divided", ""),
        ("Faster than allowed", str(above), "lines whose motions have no single F" if above else "", ""),
    ]
    return shell.cards(figures)


def _range(time: ProgramTime) -> str:
    if time.range is None or not time.range.most > time.range.least:
        return ""
    return f", {format_time(time.range.least)} to {format_time(time.range.most)}"


def _operations(found: NewFeeds) -> list[str]:
    rows = []
    for old, new in zip(found.before.parts, found.after.parts):
        share = saved(old.time, new.time)
        bar = f'<span class="meter"><span style="width:{100.0 * min(max(share, 0.0), 1.0):.1f}%"></span></span>'
        cells = [format_time(old.time), format_time(new.time), format_time(old.time - new.time) if share > 0.0 else "-"]
        numbers = "".join(f"<td>{cell}</td>" for cell in cells)
        name, tool = (escape(printable(each)) or "-" for each in (old.name, old.tool))
        rows.append(
            f'<tr><th>{name}</th><th>{tool}</th>{numbers}<td><div class="use">{bar}<b>{100.0 * share:.1f} %</b></div>'
            "</td></tr>"
        )
    return rows


def _loads(largest: tuple[LargestLoad, ...]) -> str:
    """A table of the largest loads by tool; empty where none are known."""
    if not largest:
        return ""
    rows = []
    for each in largest:
        name, scale, unit = LOADS[each.kind]
        values = "".join(f"<td>{format_figure(scale * value)} {unit}</td>" for value in (each.before, each.after))
        rows.append(f"<tr><th>{escape(printable(each.tool)) or '-'}</th><th>{name}</th>{values}</tr>")
    head = "<th>tool</th><th>largest</th><th>before</th><th>after</th>"
    return (
        '<section class="panel"><h2>Largest loads</h2><div class="scroll"><table class="figures"><thead><tr>'
        f"{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div></section>"
    )


def _notes(found: NewFeeds) -> str:
    """Sentences: what holds of all feeds, what stays as it was and why, who taught them, and where the program is above
    a limit."""
    plan = found.plan
    sentences = [
        f"operation {each.name or '-'}, tool {each.tool or '-'}: {60.0 * each.before:.0f} rpm, "
        + (f"{60.0 * each.after:.0f} rpm after: " if each.ratio != 1.0 else "which stay: ") + each.reason
        for each in found.spindle if not math.isnan(each.before)
    ]  # fmt: skip
    sentences += [*plan.notes, *(each.told(LISTED) for each in plan.kept)]
    sentences += [
        f"teacher: {f'{each.program}, ' * bool(each.program)}line {each.line}, tool {each.tool}: chip "
        f"{1e6 * each.chip:.3g} µm, area {1e6 * each.area:.3g} mm², edge {1e3 * each.edge:.3g} mm, "
        f"for {format_time(each.seconds)}"
        for each in by_line(plan.teachers)[:LISTED]
    ]
    for each in plan.overloads[:LISTED]:
        what = "however slow, the load" if each.always else "the feed of the program"
        place = f"line {each.line}, tool {each.tool}"
        sentences.append(f"{place}: {what} is {each.share:.3g} times what {each.limit} allows")
    sentences += found.written.told(LISTED)
    items = "".join(f"<li>{escape(printable(each))}</li>" for each in sentences)
    return f'<section class="panel"><h2>Notes</h2><ul>{items}</ul></section>' if items else ""


def _legend(tracks: CutTracks) -> str:
    """What the curves before and after are."""
    shown = [panel for panel in KINDS if any(each.panel == panel for each in tracks.tracks)]
    what = "feeds" if shown == ["program_feed"] else "feeds, and loads where something may be cut"
    return (
        f'<p class="hint">Before and after: {what}, at the speeds that the control reaches by its model, and at their '
        "places in the motion of the program as it was. Stock and speed of the tip are of that motion.</p>"
    )
