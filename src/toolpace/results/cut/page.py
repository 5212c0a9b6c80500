"""The page of a cut: air and material, removal rate, engagement and speed over time, and the findings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.units import MILLIMETRE, MINUTE, format_length, format_time
from toolpace.cutting.simulation.findings import Finding
from toolpace.cutting.simulation.operation_cut import CutStretch, OperationCut
from toolpace.cutting.simulation.simulate import CutSimulation
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath
from toolpace.results.report import shell

BINS = 2400
"""Stretches of time that are drawn: two for each pixel."""
PLACES = 12_000
"""Places of the path in space."""
STATES = ("air", "cutting", "not sure", "rapid")
"""What the tool is doing; their order is that of the page's colours."""
LISTED = 200
"""Findings in the page."""
WORDS = {
    "rapid": "rapid through", "holder": "holder in", "shank": "shank in", "gouge": "cuts into",
    "flute": "cuts above its flutes in", "air": "cuts nothing of",
}  # fmt: skip


class OverTime(NamedTuple):
    """What happens in each of k stretches of time, equally long."""

    edges: Floats
    """(k + 1,) [s]"""
    rate: Floats
    """(k,) removal rate [m3/s]."""
    width: Floats
    """(k,) most width of the cut [m]."""
    depth: Floats
    """(k,) most depth of the cut [m]."""
    speed: Floats
    """(k,) mean speed of the tip [m/s]."""
    feed: Floats
    """(k,) most feed that the program asks for [m/s]; nan where it asks for none."""
    state: Ints
    """(k,) index in STATES of what the tool does in its middle; -1 where it rests."""


def over_time(simulation: CutSimulation, trajectory: Trajectory, toolpath: ToolPath, bins: int = BINS) -> OverTime:
    """What the motion does over time."""
    edges = np.linspace(0.0, trajectory.duration, bins + 1)
    removed, way, width, depth = (np.zeros(bins) for _ in range(4))
    state = np.full(bins, -1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    for each in simulation.stretches:
        time, engagement = each.stations.time, each.engagement
        removed += spread(edges, time, engagement.removed)
        step = np.linalg.norm(np.diff(each.stations.tip, axis=0, prepend=each.stations.tip[:1]), axis=1)
        way += spread(edges, time, step)
        # of each bin the way that its middle is on, and of shorter ways the largest values
        here = np.flatnonzero((middle >= time[0]) & (middle <= time[-1]))
        on = np.minimum(np.searchsorted(time, middle[here]), len(time) - 1)
        state[here] = states_of(each)[on]
        contact = each.contact(engagement)
        at = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, bins - 1)
        for drawn, values in ((width, engagement.width), (depth, engagement.depth)):
            of_contact = np.where(contact, values, 0.0)
            drawn[here] = np.maximum(drawn[here], of_contact[on])
            np.maximum.at(drawn, at, of_contact)
    long = np.diff(edges)
    return OverTime(edges, removed / long, width, depth, way / long, feed_at(toolpath, trajectory, middle), state)


def spread(edges: Floats, time: Floats, amount: Floats) -> Floats:
    """(k,) of amounts on the way to each station (n,), how much falls between each two edges (k + 1,)."""
    if len(time) < 2:
        return np.zeros(len(edges) - 1)
    whole: Floats = np.diff(np.interp(edges, time, np.cumsum(amount) - amount[0]))
    return whole


def states_of(stretch: CutStretch) -> Ints:
    """(n,) index in STATES of the way to each station."""
    if stretch.rapid:
        return np.full(len(stretch.stations), STATES.index("rapid"))
    return np.where(stretch.air, 0, np.where(stretch.cutting, 1, 2))


def feed_at(toolpath: ToolPath, trajectory: Trajectory, t: Floats) -> Floats:
    """(n,) the feed that the program asks for at times t (n,) [m/s]; nan where it asks for none."""
    run, s = trajectory.run_at(t), trajectory.parameter(t)
    found = np.full(len(t), np.nan)
    for k in np.unique(run).tolist():
        of_run = np.flatnonzero(run == k)
        start, entry = trajectory.axis_path.runs[k].entries()
        at = np.clip(np.searchsorted(start, s[of_run], side="right") - 1, 0, len(entry) - 1)
        found[of_run] = toolpath.feed[entry[at]]
    return np.where(np.isfinite(found), found, np.nan)


def cut_page(
    simulation: CutSimulation, trajectory: Trajectory, toolpath: ToolPath, program: str, machine: str
) -> str:
    """The page as HTML; it opens without a network."""
    collisions = simulation.collisions
    if collisions:
        badge, kind = f"{len(collisions)} collision{'s' * (len(collisions) > 1)}", "bad"
    elif simulation.guessed:
        badge, kind = "guessed stock", "quiet"
    else:
        badge, kind = "no collision found", "good"
    fields = {
        "program": escape(program),
        "machine": escape(machine),
        "badge": f'<span class="badge {kind}">{badge}</span>',
        "warning": _warning(simulation),
        "cards": _cards(simulation, trajectory),
        "operations": "\n".join(_operation(each) for each in simulation.operations),
        "findings": _findings(simulation.findings),
        "unseen": escape(_unseen(simulation)),
        "assumed": "".join(f"<li>{escape(each)}</li>" for each in simulation.assumed) or "<li>nothing</li>",
    }
    data = _data(over_time(simulation, trajectory, toolpath), simulation)
    return shell.whole_page("toolpace.results.cut", "page", "What the tool cuts", fields, data)


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
        kind = "collision" if each.collision else "air"
        rows.append(
            f'<tr class="{kind}"><td>{line}</td><td>{escape(what)}</td><td>{depth}</td><td>{place}</td>'
            f"<td>{escape(by)}</td></tr>"
        )
    if len(findings) > LISTED:
        rows.append(f'<tr><td colspan="5">and {len(findings) - LISTED} more: cut.json has all</td></tr>')
    return "\n".join(rows)


def _data(drawn: OverTime, simulation: CutSimulation) -> str:
    """All that the script draws, as JSON that cannot end the element it stands in."""
    data = {
        "end": float(drawn.edges[-1]),
        "rate": _rounded(60e6 * drawn.rate),
        "width": _rounded(drawn.width / MILLIMETRE),
        "depth": _rounded(drawn.depth / MILLIMETRE),
        "speed": _rounded(drawn.speed / MILLIMETRE * MINUTE),
        "feed": _rounded(drawn.feed / MILLIMETRE * MINUTE),
        "state": drawn.state.tolist(),
        "states": STATES,
        "way": _way(simulation),
        "findings": [
            {"x": [round(x / MILLIMETRE, 4) for x in each.place], "text": f"line {each.line}: {WORDS[each.kind]} "
             f"{each.body}", "time": round(each.time, 4)}
            for each in simulation.collisions[:LISTED]
        ],
    }  # fmt: skip
    return json.dumps(data).replace("<", "\\u003c")


def _way(simulation: CutSimulation) -> dict[str, object]:
    """The way of the tip in space, a place of each of many stretches, and what the tool is doing on the way to it."""
    if not simulation.stretches:
        return {"x": [], "y": [], "z": [], "state": []}
    tip = np.concatenate([each.stations.tip for each in simulation.stretches])
    state = np.concatenate([states_of(each) for each in simulation.stretches])
    # every change of state is kept, so that colours begin where they should
    stride = max(1, len(tip) // PLACES)
    kept = (np.arange(len(tip)) % stride == 0) | (np.diff(state, append=state[-1:]) != 0)
    kept[-1] = True
    at = np.flatnonzero(kept)
    return {
        **{axis: [float(f"{x:.6g}") for x in tip[at, k] / MILLIMETRE] for k, axis in enumerate("xyz")},
        "state": state[at].tolist(),
    }


def _rounded(values: Floats) -> list[float | None]:
    return [float(f"{value:.4g}") if np.isfinite(value) else None for value in values]


def _volume(volume: float) -> str:
    return f"{volume * 1e6:.4g} cm³" if volume >= 1e-6 else f"{volume * 1e9:.4g} mm³"
