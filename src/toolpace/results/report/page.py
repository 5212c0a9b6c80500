"""The report page: tables, and data for its script."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.units import format_time
from toolpace.common.value_objects import counted
from toolpace.machine.limits import KINDS
from toolpace.motion.setpoints import SetPoints
from toolpace.results.report.figures import PlanFigures
from toolpace.results.report.limiting import NOTHING, binding, limit_names
from toolpace.results.report.operations import operations_section
from toolpace.results.report.scene import scene_data, stations
from toolpace.results.report.series import blocks_over_time, channels, deviations, encoded, feed_cap, packed
from toolpace.results.report.shell import whole_page
from toolpace.results.report.words import (
    NEUTRAL,
    at_most,
    colours,
    four_digits,
    joint_colour,
    limit_words,
    mesh_gap,
    motion_gap,
    percent,
)

if TYPE_CHECKING:
    from toolpace.judge import Verification
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.toolpath import ToolPath

PLACES = 12
"""Places where the lower bound leaves room that are listed: as many as are looked at."""
WORTH_A_WORD = 1e-3
"""Gap from which they are listed."""
SHOWN = 5e-4
"""Share of the time below which a limit gets no bar: it would say 0.0 %."""
BARS = 12
"""Limits that get a bar at most: of more, the least are hardly seen."""
SIDES = {"outside": "only out of the part", "above": "only up along the tool"}
"""Words of tolerances that say on which side of the program the tip must be, and what they mean."""
STRIP = 20_000
"""Columns of the strip that shows what limits where: enough to draw it larger ten times on a wide screen."""


def report_page(
    trajectory: Trajectory,
    setpoints: SetPoints,
    toolpath: ToolPath | None,
    verification: Verification | None,
    figures: PlanFigures | None,
) -> str:
    """The whole HTML text."""
    machine = trajectory.axis_path.machine
    units = ["rad" if r else "m" for r in machine.is_rotary] if machine is not None else [""] * len(setpoints.joints)
    source = toolpath.source if toolpath is not None else ""
    program = (figures.program if figures is not None else "") or source or "motion"
    where = (figures.machine if figures is not None else "") or (machine.name if machine is not None else "")
    title = f"{program} on {where}" if where else program
    palette = colours(setpoints.joints)
    fields = {
        "program": escape(program),
        "machine": escape(where),
        "verdict": _verdict(verification),
        "cards": _cards(trajectory, setpoints, toolpath, verification, figures),
        "insight": _insight(trajectory.limited_by()),
        "bars": _bars(trajectory.limited_by(), palette),
        "open_places": _open_places(trajectory),
        "usage": _usage(trajectory, units),
        "operations": operations_section(trajectory, toolpath),
        "checks": _checks(verification),
        "planner": escape(trajectory.planner),
        "points": f"{len(setpoints):,}".replace(",", " "),
    }
    data = _data(trajectory, setpoints, toolpath, units, palette, figures)
    return whole_page("toolpace.results.report", "page", title, fields, data)


def _data(
    trajectory: Trajectory,
    setpoints: SetPoints,
    toolpath: ToolPath | None,
    units: list[str],
    palette: Mapping[str, str],
    figures: PlanFigures | None,
) -> str:
    """All that the script draws, as JSON that cannot end the element it stands in."""
    columns = min(STRIP, 4 * len(setpoints))
    strip_times = np.asarray((np.arange(columns) + 0.5) * (trajectory.duration / columns), dtype=np.float64)
    curves = channels(setpoints, trajectory.limits, units, toolpath)
    if figures is not None:
        curves += deviations(trajectory, setpoints.t, figures.tip_tolerance_mm, figures.axis_tolerance_deg)
    data: dict[str, object] = {
        "end": float(setpoints.t[-1]),
        "duration": float(trajectory.duration),
        "joints": list(setpoints.joints),
        "channels": [packed(channel) for channel in curves],
        "blocks": blocks_over_time(setpoints),
        "limits": [limit_words(name) for name in limit_names(setpoints.joints)],
        "colours": list(palette.values()),
        "joint_colours": [joint_colour(j) for j in range(len(setpoints.joints))],
        "strip": encoded(binding(trajectory, strip_times).astype("<i2")),
        "nothing": NOTHING,
    }
    if setpoints.has_tool:
        at = stations(setpoints)
        cap = feed_cap(setpoints, toolpath) if toolpath is not None else None
        times = np.asarray(np.minimum(setpoints.t[at], trajectory.duration), dtype=np.float64)
        limiting = binding(trajectory, times)
        data["scene"] = scene_data(setpoints, at, limiting, cap)
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _verdict(verification: Verification | None) -> str:
    """A badge: verified, failed, or not judged."""
    if verification is None:
        return '<span class="badge quiet">not verified</span>'
    if verification.ok:
        return f'<span class="badge good">verified · {len(verification.checks)} checks</span>'
    return f'<span class="badge bad">verification failed · {len(verification.findings)} findings</span>'


def _cards(
    trajectory: Trajectory,
    setpoints: SetPoints,
    toolpath: ToolPath | None,
    verification: Verification | None,
    figures: PlanFigures | None,
) -> str:
    """The figures one asks for first."""
    cards = [("Time", format_time(trajectory.duration), "from rest to rest", "big")]
    if trajectory.lower_bound > 0.0 and math.isfinite(trajectory.lower_bound):
        note = mesh_gap(trajectory.gap)
        if trajectory.continuous_bound > 0.0:
            note += f"; {motion_gap(trajectory.duration, trajectory.continuous_bound)}"
        cards.append(("Gap", at_most(trajectory.gap), note, ""))
    if setpoints.has_tool:
        length = float(setpoints.tip_steps.sum())
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
    return "\n".join(
        f'<div class="card {kind}"><div class="label">{escape(label)}</div><div class="value">{escape(value)}</div>'
        f'<div class="note">{escape(note)}</div></div>'
        for label, value, note, kind in cards
    )


def _side(tolerances: str | None) -> str:
    """Where alone the tip may be, in the words of tolerances as plan.json has them; empty where that is both sides."""
    words = (tolerances or "").split(",")
    return next((f"; {told}" for word, told in SIDES.items() if word in words), "")


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


def _worse(told: float | None, judged: float | None, scale: float) -> float | None:
    """The larger of two deviations as far as they are known, in shop-floor units."""
    known = [float(told)] if told is not None else []
    known += [judged * scale] if judged is not None and math.isfinite(judged) else []
    return max(known) if known else None


def _insight(shares: Mapping[str, float]) -> str:
    """One sentence: what to change to be faster."""
    ranked = [(name, share) for name, share in shares.items() if name not in ("nothing", "dwell")]
    if not ranked:
        return "No limit is reached at any time."
    name, share = max(ranked, key=lambda item: item[1])
    text = f"<b>{escape(limit_words(name))}</b> limits the motion for {percent(share)} of the time"
    if name == "feed":
        return f"{text}: a higher feed in the program saves the most."
    return f"{text}: that limit costs the most time."


def _bars(shares: Mapping[str, float], palette: Mapping[str, str]) -> str:
    """Share of the time that each limit binds, largest first, as bars."""
    rows = []
    shown = [(name, share) for name, share in shares.items() if share >= SHOWN]
    top = max((share for _, share in shown), default=1.0)
    for name, share in sorted(shown, key=lambda item: -item[1])[:BARS]:
        colour = palette.get(name, NEUTRAL)
        rows.append(
            f'<div class="bar"><span class="name">{escape(limit_words(name))}</span>'
            f'<span class="track"><span class="fill" style="width:{100.0 * share / top:.2f}%;background:{colour}">'
            f'</span></span><span class="share">{percent(share)}</span></div>'
        )
    return "\n".join(rows)


def _open_places(trajectory: Trajectory) -> str:
    """Where the lower bound leaves room, the most first, folded away."""
    places = sorted(trajectory.open_places, key=lambda place: -place.seconds)[:PLACES]
    if not places or trajectory.gap < WORTH_A_WORD:
        return ""
    rows = "".join(
        f"<tr><td>{format_time(place.start)} to {format_time(place.end)}</td><td>{place.block or ''}</td>"
        f"<td>{four_digits(1e3 * place.seconds)} ms</td></tr>"
        for place in places
    )
    most = four_digits(1e3 * (trajectory.duration - trajectory.lower_bound))
    return (
        f'<details class="open"><summary>At most {most} ms ({at_most(trajectory.gap)}) slower than the best '
        "possible: where</summary>"
        '<div class="scroll"><table class="checks"><thead><tr><th>Time</th><th>Block</th><th>At most</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div></details>"
    )


def _usage(trajectory: Trajectory, units: list[str]) -> str:
    """Peak use of every limit: a row an axis, a column a kind, with the figures behind the percentage."""
    usage, limits = trajectory.usage(), trajectory.limits
    per = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}
    head = "".join(f"<th>{kind.capitalize()}</th>" for kind in KINDS)
    rows = []
    for j, joint in enumerate(trajectory.joints):
        scale, unit = {"m": (1e3, "mm"), "rad": (180.0 / math.pi, "°")}.get(units[j], (1.0, ""))
        cells = []
        for kind in KINDS:
            share, limit = getattr(usage, kind)[joint], float(getattr(limits, kind)[j]) * scale
            text = f"of {four_digits(limit)} {unit}{per[kind]}" if math.isfinite(limit) else "no limit"
            cells.append(
                f'<td><div class="use"><span class="meter"><span style="width:{100.0 * min(share, 1.0):.1f}%;'
                f'background:{joint_colour(j)}"></span></span><b>{percent(share)}</b></div><small>{text}</small></td>'
            )
        rows.append(f'<tr><th><i style="background:{joint_colour(j)}"></i>{escape(joint)}</th>{"".join(cells)}</tr>')
    feed = f'<p class="feed">Feed: <b>{percent(usage.feed)}</b> of what the program allows, at its peak.</p>'
    return f'<table class="usage"><thead><tr><th></th>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table>{feed}'


def _checks(verification: Verification | None) -> str:
    """Every check of the verification, failed ones first, folded away where all is well."""
    if verification is None:
        return ""
    rows = []
    for row in sorted(verification.rows(), key=lambda row: row[-1] == "ok"):
        *cells, verdict = (escape(cell) for cell in row)
        shown = "".join(f"<td>{cell}</td>" for cell in cells)
        rows.append(f'<tr class="{"ok" if verdict == "ok" else "failed"}">{shown}<td>{verdict}</td></tr>')
    fold = "" if verification.ok else " open"
    return (
        f'<section class="panel"><details{fold}><summary><h2>Verification</h2><span>from {verification.set_points} '
        f"set-points every {verification.dt * 1e3:g} ms, the machine and the program alone</span></summary>"
        '<div class="scroll"><table class="checks"><thead><tr><th>Check</th><th>Worst</th><th>Allowed</th>'
        f"<th>Where</th><th></th></tr></thead><tbody>{''.join(rows)}</tbody></table></div></details></section>"
    )
