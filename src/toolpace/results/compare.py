"""Comparison of plans by operation, by limit and over the path, from their folders; and its page."""

from __future__ import annotations

import itertools
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import format_time
from toolpace.motion.set_point_files import read_set_points, set_points_file
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.results.report.charts import tip_speed
from toolpace.results.report.shell import whole_page
from toolpace.results.report.words import LEAST_SHARE, OPERATIONS, at_most, joint_colour, limit_words
from toolpace.results.write import PlanRecord, read_plan

FEWEST, MOST = 2, 8
"""Plans that are compared: more are a batch."""
CURVE = 6000
"""Points of a curve over the way."""
ALIKE = 0.01
"""Share by which ways may differ in length to be one way, of which it can be told who is where when."""
Row = tuple[str, tuple[float | None, ...]]
"""A name, and a figure of each plan; None where a plan has no such thing."""


@dataclass(frozen=True)
class Compared:
    """Plans side by side; times in s, in the order of the plans."""

    folders: tuple[Path, ...]
    names: tuple[str, ...]
    """What tells the plans apart."""
    records: tuple[PlanRecord, ...]
    operations: tuple[Row, ...]
    """Time of each operation with its tool, in the order of the programs."""
    limits: tuple[Row, ...]
    """Time in which each limit binds, the most first: the share of the duration in plan.json, times the duration."""

    @property
    def durations(self) -> tuple[float, ...]:
        """[s]"""
        return tuple(record.duration_s for record in self.records)

    @property
    def programs_differ(self) -> bool:
        """Whether the plans are of programs of different names."""
        return len({record.program for record in self.records}) > 1


def compared(folders: Sequence[str | Path]) -> Compared:
    """Compare the plans in these folders. Raises UsageError where one is none, or they are too few or too many."""
    if not FEWEST <= len(folders) <= MOST:
        raise UsageError(f"{len(folders)} plans: give {FEWEST} to {MOST} folders that `toolpace plan` wrote")
    paths = tuple(Path(folder) for folder in folders)
    records = tuple(read_plan(path) for path in paths)
    shares = [record.limited_by for record in records]
    limits = [
        (name, tuple(share.get(name, 0.0) * record.duration_s for share, record in zip(shares, records)))
        for name in dict.fromkeys(name for share in shares for name in share)
    ]
    limits.sort(key=lambda row: -max(row[1]))
    return Compared(paths, _names(paths), records, tuple(_operations(records)), tuple(limits))


def _names(paths: Sequence[Path]) -> tuple[str, ...]:
    """The last parts of the paths, as many as it takes to tell them apart; numbers where nothing does."""
    parts = [path.resolve().parts for path in paths]
    for count in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-count:]) for part in parts]
        if len(set(names)) == len(names):
            return tuple(names)
    return tuple(f"{part[-1]} ({number})" for number, part in enumerate(parts, start=1))


def _operations(records: Sequence[PlanRecord]) -> Iterator[Row]:
    """Operations with the same name and tool are the same; the second of a name is the second of the others."""
    times: list[dict[tuple[str, str, int], float]] = []
    for record in records:
        met: Counter[tuple[str, str]] = Counter()
        found = {}
        for each in record.operations:
            met[each.name, each.tool] += 1
            found[each.name, each.tool, met[each.name, each.tool]] = each.time_s
        times.append(found)
    keys = dict.fromkeys(key for found in times for key in found)
    nameless = "before any operation" if len(keys) > 1 else "the whole program"
    for name, tool, number in keys:
        words = " ".join(word for word in (name, f"tool {tool}" if tool else "") if word) or nameless
        words += f", {number} of this name" if number > 1 else ""
        yield words, tuple(found.get((name, tool, number)) for found in times)


@dataclass(frozen=True)
class MotionAlong:
    """A motion along the way of its tip."""

    way: Floats
    """(n,) [m], never falling."""
    speed: Floats
    """(n,) [m/s]."""
    t: Floats
    """(n,) [s]."""


def along(folder: Path) -> MotionAlong | None:
    """The motion of a plan; None where it was written without set-points, or has no tool. Raises UsageError."""
    if not set_points_file(folder):
        return None
    setpoints = read_set_points(folder)
    if not setpoints.has_tool or len(setpoints) < 2:
        return None
    return MotionAlong(np.concatenate(([0.0], np.cumsum(setpoints.tip_steps))), tip_speed(setpoints), setpoints.t)


def thinned(motion: MotionAlong) -> tuple[Floats, Floats]:
    """Way [m] and speed [m/s] of at most `CURVE` points: of each stretch the slowest and the fastest."""
    n = len(motion.way)
    if n <= CURVE:
        return motion.way, motion.speed
    edges = np.linspace(0, n, CURVE // 2 + 1).astype(np.int64)
    picked = []
    for first, last in itertools.pairwise(edges):
        stretch = motion.speed[first:last]
        picked += sorted((int(first + stretch.argmin()), int(first + stretch.argmax())))
    at = np.array(picked)
    return motion.way[at], motion.speed[at]


def later(motion: MotionAlong, first: MotionAlong) -> tuple[Floats, Floats] | None:
    """Along the way of the first [m], how much later than it another motion is at each place [s].

    None where the ways differ: they are then not of one path. Places are matched by the share of the way.
    """
    length, other = first.way[-1], motion.way[-1]
    if not length > 0.0 or abs(other / length - 1.0) > ALIKE:
        return None
    share = np.linspace(0.0, 1.0, CURVE // 4)
    return share * length, _when(motion, share) - _when(first, share)


def _when(motion: MotionAlong, share: Floats) -> Floats:
    """(n,) when the tip leaves the places at these shares of its way [s]."""
    at = np.searchsorted(motion.way, share * motion.way[-1], side="right")
    before, after = np.clip(at - 1, 0, None), np.clip(at, None, len(motion.way) - 1)
    step = motion.way[after] - motion.way[before]
    part = np.where(step > 0.0, (share * motion.way[-1] - motion.way[before]) / np.where(step > 0.0, step, 1.0), 0.0)
    found: Floats = motion.t[before] + part * (motion.t[after] - motion.t[before])
    return found


def comparison_page(plans: Compared) -> str:
    """The whole HTML text; about 5 MB of it are plotly.js. Raises UsageError where set-points are damaged."""
    title = f"{len(plans.names)} plans of {plans.records[0].program}" if not plans.programs_differ else "Plans compared"
    data, hint = _curves(plans)
    limits = [(limit_words(name), times) for name, times in plans.limits if _seen(times, plans)]
    most = sorted(plans.operations, key=lambda row: -max(time or 0.0 for time in row[1]))[:OPERATIONS]
    operations = [row for row in plans.operations if row in most]
    fields = {
        "lead": escape("; ".join(f"{name}: {record.machine}" for name, record in zip(plans.names, plans.records))),
        "plans": _plans(plans),
        "hint": hint,
        "operations": _table("Operation", plans, operations),
        "limits": _table("Limit", plans, limits),
    }
    return whole_page("toolpace.results.report", "comparison", title, fields, data)


def _seen(times: Sequence[float | None], plans: Compared) -> bool:
    return max(time or 0.0 for time in times) >= LEAST_SHARE * max(plans.durations)


def _curves(plans: Compared) -> tuple[str, str]:
    """What the script draws, as JSON that cannot end its element, and what there is to say of it."""
    motions = [along(folder) for folder in plans.folders]
    first = motions[0]
    drawn = []
    for number, (name, motion) in enumerate(zip(plans.names, motions)):
        plan: dict[str, object] = {"name": name, "colour": joint_colour(number)}
        if motion is not None:
            way, speed = thinned(motion)
            plan["speed"] = [_short(1e3 * way), _short(60e3 * speed)]
            behind = later(motion, first) if first is not None and number else None
            if behind is not None:
                plan["later"] = [_short(1e3 * behind[0]), _short(behind[1])]
        drawn.append(plan)
    missing = [name for name, motion in zip(plans.names, motions) if motion is None]
    hint = f"Not drawn, since there are no set-points of a tool: {escape(', '.join(missing))}." if missing else (
        "Drag to zoom, double-click to see all again."
    )  # fmt: skip
    return json.dumps(drawn, separators=(",", ":")).replace("<", "\\u003c"), hint


def _short(values: Floats) -> list[float]:
    return [float(f"{value:.5g}") for value in values]


def _plans(plans: Compared) -> str:
    """A row a plan."""
    head = "".join(
        f"<th{' class=n' if k > 2 else ''}>{name}</th>"
        for k, name in enumerate(
            ("Plan", "Program", "Machine", "Time", "Against the first", "Gap", "Tolerances", "Stops", "Verdict")
        )
    )
    rows = []
    for number, (name, record) in enumerate(zip(plans.names, plans.records)):
        cells = (
            format_time(record.duration_s),
            _against(record.duration_s, plans.durations[0]) if number else "",
            at_most(record.gap) if record.gap is not None else "",
            _tolerances(record),
            str(record.stops),
            said_verdict(record),
        )
        figures = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
        mark = f'<i style="background:{joint_colour(number)}"></i>'
        words = "".join(f"<td>{escape(word)}</td>" for word in (record.program, record.machine))
        rows.append(f"<tr><td>{mark}{escape(name)}</td>{words}{figures}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def said_verdict(record: PlanRecord) -> str:
    """As plan.json has it; `toolpace verify` verifies again."""
    if record.verified is None:
        return "not verified"
    return "verified" if record.verified and record.usage.worst <= PROMISED else "failed"


def _tolerances(record: PlanRecord) -> str:
    tip = f"{1e3 * record.tip_tolerance_mm:.4g} µm" if record.tip_tolerance_mm else ""
    axis = f"{record.axis_tolerance_deg:.4g}°" if record.axis_tolerance_deg else ""
    return ", ".join(word for word in (tip, axis) if word)


def _against(time: float, first: float) -> str:
    return f"{100.0 * (time / first - 1.0):+.2f} %" if first > 0.0 else ""


def _table(what: str, plans: Compared, rows: Sequence[Row]) -> str:
    """Times of all plans, and how the last differs from the first where there are two."""
    two = len(plans.names) == 2
    head = f"<th>{what}</th>" + "".join(f'<th class="n">{escape(name)}</th>' for name in plans.names)
    head += '<th class="n">difference</th>' if two else ""
    body = []
    for name, times in rows:
        cells = ["" if time is None else format_time(time) for time in times]
        if two:
            cells.append("" if None in times else f"{(times[1] or 0.0) - (times[0] or 0.0):+.2f} s")
        body.append(f"<tr><td>{escape(name)}</td>{''.join(f'<td class=n>{escape(cell)}</td>' for cell in cells)}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(body)}</tbody></table>"
