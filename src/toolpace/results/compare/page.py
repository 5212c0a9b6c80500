"""The page of plans side by side: their motions played together, the time gained over the path, and tables."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from toolpace.common.errors import printable
from toolpace.common.units import MILLIMETRE, MINUTE, format_time
from toolpace.results.compare.motions import PlannedMotion, place_times, same_places
from toolpace.results.compare.plans import Compared, Row, verdict_words
from toolpace.results.report import shell
from toolpace.results.report.charts import Curves
from toolpace.results.report.keyframes import MOST
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.page import units_of
from toolpace.results.report.player_data import motion_data, page_json
from toolpace.results.report.words import (
    LEAST_SHARE,
    OPERATIONS,
    at_most,
    four_digits,
    joint_colour,
    limit_words,
    savings,
)
from toolpace.results.write import PlanRecord

PLAYER = (
    "arrays", "motion", "playback", "tracks", "way", "scene", "program", "player", "transport", "comparison",
    "compared_tracks",
)  # fmt: skip
"""Scripts on which that of the page stands: the report's player, and its own."""
MM_PER_MIN = MINUTE / MILLIMETRE
TICK = 1e-5
"""Times of places are multiples of it [s]."""
HEADINGS = ("Plan", "Program", "Machine", "Time", "Against the first", "Gap", "Tolerances", "Stops", "Verdict")


def comparison_page(plans: Compared) -> str:
    """The whole HTML text. Raises UsageError where files of a plan are damaged or were changed."""
    several = f"{len(plans.names)} plans of {plans.records[0].program}"
    title = ", ".join(plans.names) if plans.programs_differ else several
    motions = [PlannedMotion.load(folder, record) for folder, record in zip(plans.folders, plans.records)]
    limits = [(limit_words(name), times) for name, times in plans.limits if _seen(times, plans)]
    still = [name for name, motion in zip(plans.names, motions) if motion is None]
    fields = {
        "lead": escape(_lead(plans)),
        "cards": _cards(plans),
        "plans": _plans(plans),
        "still": f"Not played, since there are no set-points of a tool: {escape(', '.join(still))}." if still else "",
        "operations": _operations(plans, motions),
        "limits": _times("Limit", plans, limits, gained=False),
        "prices": _prices(plans),
    }
    return shell.whole_page(__package__, "page", title, fields, _data(plans, motions), PLAYER)


def _lead(plans: Compared) -> str:
    machines = list(dict.fromkeys(record.machine for record in plans.records))
    if len(machines) == 1:
        return f"on {machines[0]}"
    return "; ".join(f"{name}: {record.machine}" for name, record in zip(plans.names, plans.records))


def _seen(times: Sequence[float | None], plans: Compared) -> bool:
    return max(time or 0.0 for time in times) >= LEAST_SHARE * max(plans.durations)


def _data(plans: Compared, motions: Sequence[PlannedMotion | None]) -> str:
    """What the script plays: the motions that there are, and when each is where the first is."""
    arrays, played = PackedArrays(), []
    there = [motion for motion in motions if motion is not None]
    times = place_times(there[0]) if there else None
    for k, (name, motion) in enumerate(zip(plans.names, motions)):
        if motion is None:
            continue
        units = units_of(motion.trajectory.axis_path.machine, motion.setpoints.joints)
        curves = Curves.of(motion.setpoints, motion.trajectory.limits, units, motion.toolpath)
        channels = [channel for channel in curves.extremes() if channel.panel == "feed"]
        # the text of a program that several plans have stands in the page once
        same = next((i for i, other in enumerate(there) if other.program == motion.program), 0)
        new = there[same] is motion
        data = motion_data(
            motion.trajectory, motion.setpoints, motion.toolpath, channels, motion.program if new else None, arrays,
            MOST // len(there),
        )  # fmt: skip
        assert times is not None
        found = times if motion is there[0] else same_places(there[0], motion, times)
        data |= {
            "name": printable(name), "colour": joint_colour(k), "text_of": same,
            "places": None if found is None else arrays.add(found, TICK),
        }  # fmt: skip
        played.append(data)
    way = None if times is None else arrays.add(there[0].way_at(times) / MILLIMETRE, 1e-4)
    return page_json({"plans": played, "way": way}, arrays)


def _cards(plans: Compared) -> str:
    """The time of each plan, and what it is against that of the first."""
    first = plans.durations[0]
    cards = []
    for k, (name, time) in enumerate(zip(plans.names, plans.durations)):
        gained = first - time
        words = f"{'gains' if gained >= 0.0 else 'loses'} {format_time(abs(gained))} ({_against(time, first)})"
        cards.append((name, format_time(time), words if k else "the first, against which the others stand", ""))
    return shell.cards(cards)


def _plans(plans: Compared) -> str:
    """A row a plan."""
    head = "".join(f"<th{' class=n' if k > 2 else ''}>{name}</th>" for k, name in enumerate(HEADINGS))
    rows = []
    for number, (name, record) in enumerate(zip(plans.names, plans.records)):
        cells = (
            format_time(record.duration_s),
            _against(record.duration_s, plans.durations[0]) if number else "",
            at_most(record.gap) if record.gap is not None else "",
            _tolerances(record),
            str(record.stops),
            verdict_words(record),
        )
        figures = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
        words = "".join(f"<td>{escape(word)}</td>" for word in (record.program, record.machine))
        rows.append(f"<tr><td>{_mark(number)}{escape(name)}</td>{words}{figures}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _mark(number: int) -> str:
    return f'<i style="background:{joint_colour(number)}"></i>'


def _tolerances(record: PlanRecord) -> str:
    tip = f"{1e3 * record.tip_tolerance_mm:.4g} µm" if record.tip_tolerance_mm else ""
    axis = f"{record.axis_tolerance_deg:.4g}°" if record.axis_tolerance_deg else ""
    return ", ".join(word for word in (tip, axis) if word)


def _against(time: float, first: float) -> str:
    return f"{100.0 * (time / first - 1.0):+.2f} %" if first > 0.0 else ""


def _operations(plans: Compared, motions: Sequence[PlannedMotion | None]) -> str:
    """Times, and mean feeds where a motion tells them; of many operations those that take longest."""
    feeds = [{} if motion is None else motion.feeds() for motion in motions]
    longest = [max(time or 0.0 for time in times) for _, times in plans.operations]
    shown = sorted(sorted(range(len(longest)), key=lambda k: -longest[k])[:OPERATIONS])
    columns = [[of_plan.get(plans.keys[k]) for of_plan in feeds] for k in shown]
    return _times("Operation", plans, [plans.operations[k] for k in shown], columns)


def _prices(plans: Compared) -> str:
    """What one percent more of each limit would save of each plan, the dearest first; empty where no plan tells."""
    found = [savings(record.prices_s, record.duration_s) for record in plans.records]
    by_name = {name: tuple(each[name][0] if name in each else None for each in found) for of in found for name in of}
    if not by_name:
        return ""
    dearest = sorted(by_name.items(), key=lambda row: -max(time or 0.0 for time in row[1]))
    table = _times("Limit", plans, [(limit_words(name), times) for name, times in dearest], gained=False)
    return (
        '<section class="panel"><h2>What 1 % more of a limit would save</h2><p class="lead">on the path of each plan, '
        f'all other limits as they are</p><div class="scroll">{table}</div></section>'
    )


def _times(
    what: str,
    plans: Compared,
    rows: Sequence[Row],
    feeds: Sequence[Sequence[float | None]] | None = None,
    gained: bool = True,
) -> str:
    """A table of times of all plans, of feeds [m/s], and where there are two plans of what the second gains, or else
    has more."""
    two, sign = len(plans.names) == 2, 1.0 if gained else -1.0
    names = [f'<th class="n">{_mark(k)}{escape(name)}</th>' for k, name in enumerate(plans.names)]
    head = f"<th>{what}</th>" + "".join(names)
    if two:
        head += f'<th class="n">{"gained" if gained else "difference"}</th>'
    if feeds is not None:
        head += "".join(f'<th class="n">{_mark(k)}mean feed</th>' for k in range(len(names)))
    body = []
    for number, (name, times) in enumerate(rows):
        cells = ["" if time is None else format_time(time) for time in times]
        if two:
            more = sign * ((times[0] or 0.0) - (times[1] or 0.0))
            cells.append("" if None in times else f"{round(more, 2) + 0.0:+.2f} s")
        if feeds is not None:
            cells += ["" if feed is None else f"{four_digits(feed * MM_PER_MIN)} mm/min" for feed in feeds[number]]
        body.append(f"<tr><td>{escape(name)}</td>{''.join(f'<td class=n>{escape(cell)}</td>' for cell in cells)}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table>"
