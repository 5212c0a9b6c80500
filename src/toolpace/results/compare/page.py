"""The page of a comparison."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape

from toolpace.common.arrays import Floats
from toolpace.common.units import format_time
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.results.compare.comparison import Compared, Row
from toolpace.results.compare.curves import along, later, thinned
from toolpace.results.report.shell import whole_page
from toolpace.results.report.words import at_most, joint_colour, limit_words
from toolpace.results.write import PlanRecord

LEAST = 5e-4
"""Share of the longest plan below which a limit is not listed."""
OPERATIONS = 200
"""Operations that are listed: the longest, in the order of the programs."""


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
    return whole_page("toolpace.results.compare", "page", title, fields, data)


def _seen(times: Sequence[float | None], plans: Compared) -> bool:
    return max(time or 0.0 for time in times) >= LEAST * max(plans.durations)


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
        told = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
        mark = f'<i style="background:{joint_colour(number)}"></i>'
        words = "".join(f"<td>{escape(word)}</td>" for word in (record.program, record.machine))
        rows.append(f"<tr><td>{mark}{escape(name)}</td>{words}{told}</tr>")
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
