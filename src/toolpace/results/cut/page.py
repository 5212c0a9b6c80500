"""The page of a cut: the motion with the stock, what the tool does over time, sums by operation, and the findings."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from toolpace.common.errors import printable
from toolpace.common.units import MILLIMETRE, format_length, format_time
from toolpace.cutting.simulation.findings import Finding
from toolpace.cutting.simulation.operation_cut import OperationCut
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.motion.sampling import Sampling
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath
from toolpace.results.report import shell
from toolpace.results.report.charts import Curves
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.page import PLAYER, units_of
from toolpace.results.report.player_data import motion_data, page_json, workpiece_data
from toolpace.results.workpiece.view import WorkpieceView

TIME_STEP = 1e-3
"""Between the set-points that the curves of the motion are of [s]."""
LISTED = 200
"""Findings in the page."""
WORDS = {
    "rapid": "rapid through", "holder": "holder in", "shank": "shank in", "gouge": "cuts into",
    "flute": "cuts above its flutes in", "left": "left above",
    "air": "cuts nothing of",
}  # fmt: skip


def cut_page(
    simulation: CutSimulation,
    trajectory: Trajectory,
    toolpath: ToolPath,
    view: WorkpieceView,
    name: str,
    machine: str,
    program: bytes | None = None,
) -> str:
    """The page as HTML; it opens without a network. `program` is what the file holds, for those who read along."""
    collisions = simulation.collisions
    if collisions:
        badge, kind = f"{len(collisions)} collision{'s' * (len(collisions) > 1)}", "bad"
    elif simulation.guessed:
        badge, kind = "guessed stock", "quiet"
    else:
        badge, kind = "no collision found", "good"
    fields = {
        "program": escape(printable(name)),
        "machine": escape(machine),
        "badge": f'<span class="badge {kind}">{badge}</span>',
        "warning": _warning(simulation),
        "cards": _cards(simulation, trajectory),
        "motion": shell.motion_section(trajectory.duration),
        "operations": "\n".join(_operation(each) for each in simulation.operations),
        "findings": _findings(simulation.findings),
        "unseen": escape(_unseen(simulation)),
        "assumed": "".join(f"<li>{escape(each)}</li>" for each in simulation.assumed) or "<li>nothing</li>",
    }
    points = Sampling(trajectory, TIME_STEP, on_grid=False)
    curves = Curves.of(points, trajectory.limits, units_of(trajectory.axis_path.machine, points.joints), toolpath)
    arrays = PackedArrays()
    data = motion_data(trajectory, points, toolpath, curves.extremes(), program, arrays)
    data |= workpiece_data(view, arrays) | {"findings": _collisions(simulation)}
    page = page_json(data, arrays)
    return shell.whole_page(__package__, "page", printable(f"What {name} cuts"), fields, page, PLAYER)


def _warning(simulation: CutSimulation) -> str:
    if not simulation.guessed:
        return ""
    return (
        '<section class="panel"><p class="lead"><b>The stock is guessed</b>: the box around all cutting moves. Nothing '
        "is concluded from it, neither air nor collisions. Tell [stock] on the set-up sheet.</p></section>"
    )


def _unseen(simulation: CutSimulation) -> str:
    """What the figures are good for."""
    ends = ""
    if simulation.uncertainty > 0.0:
        ends = f" The stock ends within {format_length(simulation.uncertainty)} of where it is said to."
    return (
        f"Cells of {format_length(simulation.resolution)}: collisions less deep than "
        f"{format_length(simulation.smallest_contact)} may not be seen.{ends}"
    )


def _cards(simulation: CutSimulation, trajectory: Trajectory) -> str:
    feed = sum(each.feed_time for each in simulation.operations)
    share = f"{100.0 * simulation.air / feed:.1f} % of the time at feed" if feed > 0.0 else "no move at feed"
    unsure = sum(each.uncertain for each in simulation.operations)
    deepest = simulation.collisions[0] if simulation.collisions else None
    peak = max((each.peak_rate for each in simulation.operations), default=0.0)
    figures = [
        ("In air, at feed", format_time(simulation.air), share, "big"),
        ("Cutting", format_time(simulation.cutting), f"{format_time(unsure)} more may be cut" if unsure else "", ""),
        ("Motion", format_time(trajectory.duration), "as planned, with rapids", ""),
        ("Removed", _volume(simulation.removed_volume), f"of {_volume(simulation.stock_volume)}", ""),
        ("Most removal rate", f"{peak * 60e6:.3g} cm³/min", "over 50 ms", ""),
        (
            "Collisions",
            str(len(simulation.collisions)),
            "" if deepest is None else f"the worst {format_length(round(deepest.depth, 5))} deep, line {deepest.line}",
            "",
        ),
    ]
    if simulation.above_part is not None:
        above = simulation.above_part
        height = f"at most {format_length(round(above.height, 6))} high"
        figures.append(("Left above the part", _volume(above.volume), height, ""))
    return shell.cards(figures)


def _operation(each: OperationCut) -> str:
    cells = [
        format_time(each.air) if each.air else "-",
        format_time(each.cutting) if each.cutting else "-",
        format_time(each.uncertain) if each.uncertain else "-",
        format_time(each.rapid) if each.rapid else "-",
        _volume(each.removed),
        f"{each.mean_rate * 60e6:.3g}",
        f"{each.peak_rate * 60e6:.3g}",
        f"{each.width / MILLIMETRE:.3g}",
        f"{each.depth / MILLIMETRE:.3g}",
    ]
    numbers = "".join(f"<td>{cell}</td>" for cell in cells)
    return f"<tr><th>{escape(each.name) or '-'}</th><th>{escape(each.tool) or '-'}</th>{numbers}</tr>"


def _findings(findings: Sequence[Finding]) -> str:
    """Rows of a table."""
    if not findings:
        return '<tr><td colspan="5">none</td></tr>'
    rows = []
    for each in findings[:LISTED]:
        line = str(each.line) if each.line == each.last_line else f"{each.line} to {each.last_line}"
        what = f"{'' if each.certain else 'may be: '}{WORDS[each.kind]} {each.body}"
        depth = format_time(each.seconds) if each.kind == "air" else format_length(round(each.depth, 5))
        place = " ".join(f"{letter}{x / MILLIMETRE:.2f}" for letter, x in zip("XYZ", each.place))
        by = ", ".join(part for part in (each.operation, each.tool) if part)
        kind = "collision" if each.collision else each.kind
        line = f'<button type="button" class="link" data-seek="{each.time:.6f}">{line}</button>'
        rows.append(
            f'<tr class="{kind}"><td>{line}</td><td>{escape(what)}</td><td>{depth}</td><td>{place}</td>'
            f"<td>{escape(by)}</td></tr>"
        )
    if len(findings) > LISTED:
        rows.append(f'<tr><td colspan="5">and {len(findings) - LISTED} more: cut.json has all</td></tr>')
    return "\n".join(rows)


def _collisions(simulation: CutSimulation) -> list[dict[str, object]]:
    """Those that are shown in space and on the time line, the worst first."""
    return [
        {
            "place": [round(x / MILLIMETRE, 4) for x in each.place], "t": each.time, "duration": each.seconds,
            "text": printable(f"line {each.line}: {WORDS[each.kind]} {each.body}"),
        }
        for each in simulation.collisions[:LISTED]
    ]  # fmt: skip


def _volume(volume: float) -> str:
    return f"{volume * 1e6:.4g} cm³" if volume >= 1e-6 else f"{volume * 1e9:.4g} mm³"
