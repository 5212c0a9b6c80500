"""The report page: its tables, and the data for its script, from a motion and its verification."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from toolpace.common.errors import printable
from toolpace.common.units import format_length, format_time
from toolpace.machine.limit_curves import CURVE
from toolpace.machine.limits import CONTINUOUS, KINDS, MOTORS
from toolpace.motion.set_point_files import MACHINE
from toolpace.motion.setpoints import SetPointSource
from toolpace.motion.trajectory import OperationTime, operation_times
from toolpace.results.report.charts import Curves
from toolpace.results.report.key_figures import PlanFigures, key_figures
from toolpace.results.report.player_data import player_data
from toolpace.results.report.shell import motion_section, whole_page
from toolpace.results.report.words import (
    BARS,
    LEAST_SHARE,
    NEUTRAL,
    OPERATIONS,
    WORTH_A_WORD,
    at_most,
    colours,
    four_digits,
    joint_colour,
    limit_words,
    limits_now,
    percent,
    savings,
)

if TYPE_CHECKING:
    from toolpace.judge import Verification
    from toolpace.machine.machine import Machine
    from toolpace.motion.trajectory import Trajectory
    from toolpace.programs.toolpath import ToolPath
    from toolpace.results.workpiece.view import WorkpieceView

PLACES = 12
"""Places where the lower bound leaves room that are listed: as many as are looked at."""
HEADINGS = ("Operation", "Tool", "Time", "Cutting", "Rapid", "Dwell", "Stops")
PLAYER = (
    "arrays", "motion", "playback", "tracks", "timeline", "way", "stock", "workpiece", "scene", "program", "player",
    "transport", "motion_page",
)  # fmt: skip
"""Scripts of pages that play one motion, in the order in which they stand on each other."""


def units_of(machine: Machine | None, joints: Sequence[str]) -> list[str]:
    """The unit of each joint, "m" or "rad"; empty where no machine tells."""
    return [""] * len(joints) if machine is None else ["rad" if r else "m" for r in machine.is_rotary]


def report_page(
    trajectory: Trajectory,
    setpoints: SetPointSource,
    toolpath: ToolPath | None,
    verification: Verification | None,
    figures: PlanFigures | None,
    curves: Curves | None = None,
    program_bytes: bytes | None = None,
    workpiece: WorkpieceView | None = None,
) -> str:
    """The whole HTML text; `curves` are those of the set-points, where they have been gathered already,
    `program_bytes` what the file of the program holds, for those who read along, and `workpiece` what is cut."""
    machine = trajectory.axis_path.machine
    units = units_of(machine, setpoints.joints)
    curves = curves or Curves.of(setpoints, trajectory.limits, units, toolpath)
    source = toolpath.source if toolpath is not None else ""
    program = printable((figures.program if figures is not None else "") or source or "motion")
    where = (figures.machine if figures is not None else "") or (machine.name if machine is not None else "")
    title = f"{program} on {where}" if where else program
    palette = colours(setpoints.joints, trajectory.limits.constants.curves)
    fields = {
        "program": escape(program),
        "machine": escape(where),
        "verdict": _verdict(verification),
        "cards": key_figures(trajectory, curves.length, toolpath, verification, figures),
        "insight": _insight(trajectory.limited_by()) + wider_tolerance(figures),
        "bars": _bars(trajectory.limited_by(), palette),
        "open_places": _open_places(trajectory),
        "prices": "" if figures is None else _prices(figures, trajectory.duration, machine),
        "usage": _usage(trajectory, units),
        "motion": motion_section(trajectory.duration, workpiece_note(workpiece)),
        "operations": _operations(trajectory, toolpath),
        "checks": _checks(verification),
        "planner": escape(trajectory.planner),
        "points": f"{len(setpoints):,}".replace(",", " "),
    }
    data = player_data(trajectory, setpoints, toolpath, curves, figures, program_bytes, workpiece)
    return whole_page("toolpace.results.report", "page", title, fields, data, PLAYER)


def _verdict(verification: Verification | None) -> str:
    """A badge: verified, failed, or not judged."""
    if verification is None:
        return '<span class="badge quiet">not verified</span>'
    if verification.ok:
        checks = len(verification.checks) - len(verification.unjudged)
        unjudged = "".join(f" · not judged: {escape(each)}" for each in verification.unjudged)
        return f'<span class="badge good">verified · {checks} checks{unjudged}</span>'
    return f'<span class="badge bad">verification failed · {len(verification.findings)} findings</span>'


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


def wider_tolerance(figures: PlanFigures | None) -> str:
    """How to find out what a wider tolerance brings, with the files beside the plan; empty without them."""
    if figures is None or not figures.program_file or figures.tip_tolerance_mm is None:
        return ""
    tips = ",".join(f"{factor * 1e3 * figures.tip_tolerance_mm:.4g}um" for factor in (1, 2, 4))
    words = [f"toolpace tolerance {figures.program_file} -m {MACHINE}"]
    reading = figures.reading
    words += [f"--controller {reading.controller_file}"] if reading.controller_file else []
    words += [f"--setup {reading.setup_file}"] if reading.setup_file else []
    command = escape(printable(" ".join([*words, f"--tips {tips}"])))
    return f" What a wider tolerance brings tells, in the folder of this page: <code>{command}</code>"


def _bars(shares: Mapping[str, float], palette: Mapping[str, str]) -> str:
    """Share of the time that each limit binds, largest first, as bars."""
    rows = []
    shown = [(name, share) for name, share in shares.items() if share >= LEAST_SHARE]
    top = max((share for _, share in shown), default=1.0)
    for name, share in sorted(shown, key=lambda item: -item[1])[:BARS]:
        colour = palette.get(name, NEUTRAL)
        rows.append(
            f'<div class="bar"><span class="name">{escape(limit_words(name))}</span>'
            f'<span class="track"><span class="fill" style="width:{100.0 * share / top:.2f}%;background:{colour}">'
            f'</span></span><span class="share">{percent(share)}</span></div>'
        )
    return "\n".join(rows)


def _prices(figures: PlanFigures, duration: float, machine: Machine | None) -> str:
    """What more of each limit would save, the most first; empty where that was not worked out."""
    if not figures.prices_s:
        return ""
    now, rows = limits_now(machine), []
    for name, times in savings(figures.prices_s, duration).items():
        cells = "".join(f'<td class="n">{format_time(each)}, {percent(each / duration)}</td>' for each in times)
        rows.append(
            f"<tr><td>{escape(limit_words(name))}</td><td>{escape(now.get(name, 'of the program'))}</td>{cells}</tr>"
        )
    head = '<th>Limit</th><th>Now</th><th class="n">1 % more saves</th><th class="n">10 % more, up to</th>'
    return (
        "<h3>What more of a limit would save</h3>"
        '<p class="hint">On this path, of one limit, with all others as they are.</p>'
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
    )


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


def workpiece_note(view: WorkpieceView | None) -> str:
    """Where the stock and the curves of the cut are from, or why they are not there."""
    if view is None or (view.stages is None and not view.note):
        return ""
    if view.note:
        text = f"The stock is not shown: {view.note}"
    else:
        text = f"Stock and curves of the cut: a simulation in cells of {format_length(round(view.resolution, 6))}"
        text += ", of a guessed stock: the box around all cutting moves" if view.guessed else ""
    return f'<p class="hint source">{escape(printable(text))}.</p>'


def _usage(trajectory: Trajectory, units: list[str]) -> str:
    """Peak use of every limit: a row an axis, a column a kind, with the figures behind the percentage."""
    usage, limits = trajectory.usage(), trajectory.limits
    per = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}
    head = "".join(f"<th>{kind.capitalize()}</th>" for kind in KINDS)
    motors = {rows.name.partition(" ")[2]: rows for rows in limits.rows if rows.name.partition(" ")[0] in MOTORS}
    head += "<th>Torque, force</th>" if motors else ""
    rows = []
    for j, joint in enumerate(trajectory.joints):
        scale, unit = {"m": (1e3, "mm"), "rad": (180.0 / math.pi, "°")}.get(units[j], (1.0, ""))
        cells = []
        for kind in KINDS:
            share, limit = getattr(usage, kind)[joint], float(getattr(limits, kind)[j]) * scale
            text = f"of {four_digits(limit)} {unit}{per[kind]}" if math.isfinite(limit) else "no limit"
            if f"{kind} {CURVE}{joint}" in limits.names:
                text += f', {percent(usage.rows[f"{kind} {CURVE}{joint}"])} at its speed'
            cells.append(_used(j, share, text))
        if joint in motors:
            motor = motors[joint]
            text = f"of {four_digits(motor.limit)} {motor.unit}"
            if CONTINUOUS + motor.name in usage.rows:
                text += f", rms {percent(usage.rows[CONTINUOUS + motor.name])}"
            cells.append(_used(j, usage.rows[motor.name], text))
        elif motors:
            cells.append("<td><small>no limit</small></td>")
        rows.append(f'<tr><th><i style="background:{joint_colour(j)}"></i>{escape(joint)}</th>{"".join(cells)}</tr>')
    feed = f'<p class="feed">Feed: <b>{percent(usage.feed)}</b> of what the program allows, at its peak.</p>'
    kind = "usage wide" if motors else "usage"
    return f'<table class="{kind}"><thead><tr><th></th>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table>{feed}'


def _used(joint: int, share: float, text: str) -> str:
    """A cell of that table."""
    return (
        f'<td><div class="use"><span class="meter"><span style="width:{100.0 * min(share, 1.0):.1f}%;'
        f'background:{joint_colour(joint)}"></span></span><b>{percent(share)}</b></div><small>{text}</small></td>'
    )


def _checks(verification: Verification | None) -> str:
    """Every check of the verification, failed ones first, folded away where all is well."""
    if verification is None:
        return ""
    rows = []
    for row in sorted(verification.rows(), key=lambda row: row[-1] == "ok"):
        *cells, verdict = (escape(cell) for cell in row)
        shown = "".join(f"<td>{cell}</td>" for cell in cells)
        rows.append(f'<tr class="{"failed" if verdict == "FAILED" else "ok"}">{shown}<td>{verdict}</td></tr>')
    fold = "" if verification.ok else " open"
    return (
        f'<section class="panel"><details{fold}><summary><h2>Verification</h2><span>from {verification.set_points} '
        f"set-points every {verification.dt * 1e3:g} ms, the machine and the program alone</span></summary>"
        '<div class="scroll"><table class="checks"><thead><tr><th>Check</th><th>Worst</th><th>Allowed</th>'
        f"<th>Where</th><th></th></tr></thead><tbody>{''.join(rows)}</tbody></table></div></details></section>"
    )


def _operations(trajectory: Trajectory, toolpath: ToolPath | None) -> str:
    """A table of operations, and what was assumed and skipped; empty where there is no program."""
    if toolpath is None:
        return ""
    tables = _operation_times(operation_times(trajectory, toolpath)) + _assumed(toolpath)
    return f'<section class="panel"><h2>Operations</h2>{tables}</section>' if tables else ""


def _operation_times(times: list[OperationTime]) -> str:
    if not times:
        return ""
    longest = sorted(range(len(times)), key=lambda k: -times[k].time)[:OPERATIONS]
    shown = [times[k] for k in sorted(longest)]
    rest = len(times) - len(shown)
    rows = "".join(_operation(each.name or "", each.tool, each, "") for each in shown)
    total = OperationTime(
        "", "", sum(each.cutting for each in times), sum(each.rapid for each in times),
        sum(each.dwell for each in times), sum(each.stops for each in times),
    )  # fmt: skip
    rows += _operation(f"all, and {rest} shorter ones" if rest else "all", "", total, ' class="ok"')
    head = "".join(f"<th>{heading}</th>" for heading in HEADINGS)
    return (
        f'<div class="scroll"><table class="checks"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _operation(name: str, tool: str, each: OperationTime, kind: str) -> str:
    cells = [printable(name), printable(tool), *map(_time, (each.time, each.cutting, each.rapid, each.dwell))]
    shown = "".join(f"<td>{escape(cell)}</td>" for cell in (*cells, str(each.stops)))
    return f"<tr{kind}>{shown}</tr>"


def _time(seconds: float) -> str:
    return format_time(seconds) if seconds else "-"


def _assumed(toolpath: ToolPath) -> str:
    """Sentences, folded away."""
    if not toolpath.assumed:
        return ""
    items = "".join(f"<li>{escape(printable(sentence))}</li>" for sentence in toolpath.assumed)
    heading = f"Assumed of the program ({len(toolpath.assumed)})"
    return f"<details><summary>{heading}</summary><ul>{items}</ul></details>"
