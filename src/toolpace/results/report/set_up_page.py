"""The page of a set-up search, with a map (SVG) of the duration over x and y."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING
from urllib.parse import quote

import numpy as np

from toolpace.common import __version__
from toolpace.common.arrays import Floats
from toolpace.common.units import DEGREE, MILLIMETRE, format_time
from toolpace.results.report import shell
from toolpace.results.report.words import BARS, NEUTRAL, at_most, colours, limit_words, percent

if TYPE_CHECKING:
    from toolpace.setup_search.found_set_up import FoundSetUp, PlaceMap, PlannedSetUp

SHOWN = 5e-3
"""Share of the time below which a limit is not, before and after."""
STYLE = """
.n { white-space: nowrap; } tr.given td { background: var(--plot); } tr.first td { font-weight: 640; }
.both .bar { padding: 1px 0; } .both .after { margin-bottom: 8px; } .both .before .fill { opacity: 0.45; }
.both .before .share { opacity: 0.7; } pre { overflow-x: auto; font-size: 12.5px; margin: 0; }
main svg { max-width: 100%; height: auto; } main svg text { fill: var(--soft); }
"""
At = Callable[[float, float], tuple[float, float]]
"""Place [mm] to pixels."""
SIDE = 420.0
"""Of the map's longer side [pixels]."""
LEFT, TOP, RIGHT, BOTTOM = 74.0, 22.0, 150.0, 62.0
"""Room around it [pixels]."""
RAMP = ((13, 74, 112), (26, 138, 138), (122, 190, 120), (240, 221, 120))
"""Colours from the least time to the most."""
INK, SOFT = "#17202e", "#5b6778"
STEPS = 5
"""Times beside the scale of colours."""
FLATTEST = 1e-3
"""Share of the least time that the scale of colours spans at least: less is no difference."""


def set_up_page(
    found: FoundSetUp,
    program: str,
    sheet: str,
    others: Sequence[tuple[str, FoundSetUp | str]] = (),
    reports: Sequence[str] = (),
) -> str:
    """The whole HTML text.

    sheet: the text of the set-up sheet. others: all machines that were searched, with what was found or why nothing.
    reports: of the plans of the best set-ups, as they are reached from the page; empty where there is none.
    """
    best = found.best[0]
    machine = escape(best.machine.name)
    parts = [
        f"<header><div><h1>{escape(program)}</h1><p>where to clamp the part on <b>{machine}</b></p></div>",
        f'<div class="ends">{shell.THEME_BUTTON}</div></header>',
        "<main>",
        f'<section class="cards">{_cards(found)}</section>',
        _machines(others),
        _panel("The best set-ups", "each planned in full, within all travels", _table(found, reports)),
        '<div class="pair">',
        _panel("Time over the place", "all else as in the best set-up; from cheap plans", _map(found)),
        _panel("What limits, before and after", "share of the time; pale as given, strong as found", _limits(found)),
        "</div>",
        _panel(
            "Set-up sheet",
            "setup.toml, for --setup with program.apt; machine.toml has it too",
            f"<pre>{escape(sheet)}</pre>",
        ),
        f"</main><footer>toolpace {escape(__version__)} · {found.trials} clampings tried · seed {found.seed}</footer>",
    ]
    return shell.framed(f"Set-up for {program} on {best.machine.name}", "\n".join(parts), STYLE)


def _panel(title: str, lead: str, body: str) -> str:
    if not body:
        return ""
    return f'<section class="panel"><h2>{escape(title)}</h2><p class="lead">{escape(lead)}</p>{body}</section>'


def _cards(found: FoundSetUp) -> str:
    best, present = found.best[0], found.given
    cards = [("Time", format_time(best.duration), best.clamping.words(best.machine), "big")]
    if present is not None:
        saved = present.duration - best.duration
        cards.append(("Gain", percent(found.gain), f"{format_time(saved)} of {format_time(present.duration)}", ""))
    else:
        cards.append(("As given", "cannot be run", found.why, ""))
    cards.append(("Gap", at_most(best.gap), "of the best set-up: its time over the lower bound on its mesh", ""))
    cards.append(("Tried", f"{found.trials}", f"clampings, in {format_time(found.seconds)}", ""))
    return shell.cards(cards, "")


def _machines(others: Sequence[tuple[str, FoundSetUp | str]]) -> str:
    """A row a machine, fastest first, where there is more than one."""
    if len(others) < 2:
        return ""
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td colspan=4>{escape(found)}</td></tr>"
        if isinstance(found, str)
        else f"<tr><td>{escape(name)}</td><td class=n>{format_time(found.best[0].duration)}</td>"
        f"<td class=n>{format_time(found.given.duration) if found.given is not None else 'cannot be run'}</td>"
        f"<td class=n>{_gain(found.best[0], found.given)}</td>"
        f"<td>{escape(found.best[0].clamping.words(found.best[0].machine))}</td></tr>"
        for name, found in sorted(others, key=time_on)
    )
    head = "<th>Machine</th><th class=n>Time</th><th class=n>As given</th><th class=n>Gain</th><th>Set-up</th>"
    body = f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
    return _panel("Machines", "each with its own best set-up; this page is of the fastest", body)


def time_on(machine: tuple[str, FoundSetUp | str]) -> float:
    """How long the program takes on a machine with its best set-up [s]; inf where none fits."""
    return math.inf if isinstance(machine[1], str) else machine[1].best[0].duration


def _gain(each: PlannedSetUp, present: PlannedSetUp | None) -> str:
    return percent(1.0 - each.duration / present.duration) if present is not None and each is not present else ""


def _table(found: FoundSetUp, reports: Sequence[str]) -> str:
    names = ("", "Time", "Gain", "Gap", "Turn", "Tilt", "Swing", "X", "Y", "Z", "Tool", "Solution")
    head = "".join(f"<th{' class=n' if i else ''}>{name}</th>" for i, name in enumerate(names))
    shown = [*found.best, *([found.given] if found.given is not None and found.given not in found.best else [])]
    links = [*reports, *[""] * (len(shown) - len(reports))]
    rows = "".join(_row(k, each, found.given, link) for k, (each, link) in enumerate(zip(shown, links), start=1))
    units = (
        "Turn, tilt and swing are about the middle of the program, in deg from how the part is clamped now; X, Y, Z: "
        "how far that middle is moved, in mm. Tool: from the spindle nose to the tip, in mm, of each tool. Solution: "
        "which half of its circle the second rotary joint keeps to; free: whichever turns least. Gap: by how much the "
        "time is slower, at most, than the best possible on its path and mesh."
    )
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
        f'<p class="hint">{units}</p>'
    )


def _row(number: int, each: PlannedSetUp, present: PlannedSetUp | None, report: str) -> str:
    clamping = each.clamping
    cells = [format_time(each.duration), _gain(each, present), at_most(each.gap)]
    cells += [_figure(angle / DEGREE) for _, angle in clamping.angles()]
    cells += [_figure(shift / MILLIMETRE) for shift in clamping.shift]
    tools = ", ".join(_figure(length / MILLIMETRE) for length in each.tool_lengths)
    cells += [tools, {0: "free", 1: "+", -1: "-"}[clamping.side]]
    kind = "given" if each is present else "first" if number == 1 else ""
    label = "as given" if each is present else f"{number}"
    if report:
        label = f'<a href="{escape(quote(report))}">{label}</a>'
    return f'<tr class="{kind}"><td>{label}</td>' + "".join(f"<td class=n>{cell}</td>" for cell in cells) + "</tr>"


def _figure(value: float) -> str:
    return f"{round(value, 2) + 0.0:g}"


def _map(found: FoundSetUp) -> str:
    return map_svg(found.places) if found.places is not None else ""


def _limits(found: FoundSetUp) -> str:
    palette = colours(found.best[0].machine.joints)
    changes = {name: both for name, both in found.changes().items() if max(both) >= SHOWN}
    top = max((max(both) for both in changes.values()), default=1.0)
    rows = (_bars(name, both, top, palette) for name, both in list(changes.items())[:BARS])
    return f'<div class="bars both">{"".join(rows)}</div>'


def _bars(name: str, both: tuple[float, float], top: float, palette: Mapping[str, str]) -> str:
    colour = palette.get(name, NEUTRAL)
    return "".join(
        f'<div class="bar {kind}"><span class="name">{escape(label)}</span><span class="track"><span class="fill" '
        f'style="width:{100.0 * share / top:.2f}%;background:{colour}"></span></span>'
        f'<span class="share">{percent(share)}</span></div>'
        for kind, label, share in (("before", limit_words(name), both[0]), ("after", "", both[1]))
    )


def map_svg(places: PlaceMap) -> str:
    """The whole drawing."""
    x, y = 1e3 * places.x, 1e3 * places.y
    dx, dy = x[1] - x[0], y[1] - y[0]
    scale = SIDE / max(np.ptp(x) + dx, np.ptp(y) + dy)
    wide, high = scale * (np.ptp(x) + dx), scale * (np.ptp(y) + dy)
    low, top = _span(places)

    def at(px: float, py: float) -> tuple[float, float]:
        return LEFT + scale * (px - x[0] + 0.5 * dx), TOP + high - scale * (py - y[0] + 0.5 * dy)

    width, height = LEFT + wide + RIGHT, TOP + high + BOTTOM
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" '
        f'height="{height:.0f}" role="img" font-family="sans-serif" font-size="12.5" fill="{SOFT}">',
        "<title>About the duration over the place of the part</title>",
        '<defs><pattern id="beyond" width="7" height="7" patternUnits="userSpaceOnUse" '
        'patternTransform="rotate(45)"><rect width="7" height="7" fill="#f1f3f6"/>'
        '<line x1="0" y1="0" x2="0" y2="7" stroke="#c3c9d2" stroke-width="2"/></pattern></defs>',
    ]
    for j, py in enumerate(y):
        for i, px in enumerate(x):
            a, b = at(px - 0.5 * dx, py + 0.5 * dy)
            seconds = float(places.seconds[j, i])
            fill = "url(#beyond)" if np.isnan(seconds) else _colour((seconds - low) / (top - low))
            title = "not possible: beyond travel, or forbidden" if np.isnan(seconds) else format_time(seconds)
            parts.append(
                f'<rect x="{a:.2f}" y="{b:.2f}" width="{scale * dx + 0.4:.2f}" height="{scale * dy + 0.4:.2f}" '
                f'fill="{fill}"><title>x {px:.4g}, y {py:.4g} mm: {escape(title)}</title></rect>'
            )
    parts += [*_ticks(x, y, at, TOP + high), *_marks(places, at), *_scale(low, top, LEFT + wide + 26.0, high)]
    return "\n".join([*parts, "</svg>"])


def _span(places: PlaceMap) -> tuple[float, float]:
    """Between which times the colours run [s]."""
    times = places.seconds[np.isfinite(places.seconds)]
    if not len(times):
        return 0.0, 1.0
    low = float(times.min())
    return low, max(float(times.max()), low * (1.0 + FLATTEST))


def _colour(share: float) -> str:
    place = min(max(share, 0.0), 1.0) * (len(RAMP) - 1)
    k = min(int(place), len(RAMP) - 2)
    rgb = [round(a + (b - a) * (place - k)) for a, b in zip(RAMP[k], RAMP[k + 1])]
    return "#" + "".join(f"{value:02x}" for value in rgb)


def _ticks(x: Floats, y: Floats, at: At, bottom: float) -> Iterator[str]:
    """Figures along both sides, and what they are."""
    every = max(1, (len(x) - 1) // 4)
    for px in x[::every]:
        a, _ = at(px, y[0])
        yield f'<text x="{a:.1f}" y="{bottom + 18:.1f}" text-anchor="middle">{px:.4g}</text>'
    for py in y[:: max(1, (len(y) - 1) // 4)]:
        _, b = at(x[0], py)
        yield f'<text x="{LEFT - 9:.1f}" y="{b + 4:.1f}" text-anchor="end">{py:.4g}</text>'
    middle, _ = at(0.5 * (x[0] + x[-1]), y[0])
    middled = f'text-anchor="middle" fill="{INK}"'
    yield f'<text x="{middle:.1f}" y="{bottom + 42:.1f}" {middled}>part moved along X [mm]</text>'
    _, centre = at(x[0], 0.5 * (y[0] + y[-1]))
    turn = f"rotate(-90 18 {centre:.1f})"
    yield f'<text x="18" y="{centre:.1f}" {middled} transform="{turn}">part moved along Y [mm]</text>'


def _marks(places: PlaceMap, at: At) -> Iterator[str]:
    """Where the part is now, and where it is best."""
    x, y = 1e3 * places.x, 1e3 * places.y
    if x[0] <= 0.0 <= x[-1] and y[0] <= 0.0 <= y[-1]:
        a, b = at(0.0, 0.0)
        yield f'<path d="M{a - 7:.1f} {b:.1f}h14M{a:.1f} {b - 7:.1f}v14" stroke="#fff" stroke-width="4.5"/>'
        yield f'<path d="M{a - 6:.1f} {b:.1f}h12M{a:.1f} {b - 6:.1f}v12" stroke="{INK}" stroke-width="2"/>'
    a, b = at(1e3 * places.best[0], 1e3 * places.best[1])
    yield f'<circle cx="{a:.1f}" cy="{b:.1f}" r="7" fill="none" stroke="#fff" stroke-width="5"/>'
    yield f'<circle cx="{a:.1f}" cy="{b:.1f}" r="7" fill="none" stroke="#d6336c" stroke-width="2.5"/>'


def _scale(low: float, top: float, left: float, high: float) -> Iterator[str]:
    """The scale of colours, and what the marks are."""
    tall = high - 110.0
    for k in range(60):
        colour = _colour(1.0 - (k + 0.5) / 60)
        box = f'x="{left:.1f}" y="{TOP + tall * k / 60:.2f}" width="16" height="{tall / 60 + 0.4:.2f}"'
        yield f'<rect {box} fill="{colour}"/>'
    for k in range(STEPS):
        share = k / (STEPS - 1)
        time = format_time(low + share * (top - low))
        yield f'<text x="{left + 23:.1f}" y="{TOP + tall * (1.0 - share) + 4:.1f}">{time}</text>'
    y = TOP + tall + 36.0
    yield f'<circle cx="{left + 8:.1f}" cy="{y:.1f}" r="7" fill="none" stroke="#d6336c" stroke-width="2.5"/>'
    yield f'<text x="{left + 23:.1f}" y="{y + 4:.1f}">best</text>'
    yield f'<path d="M{left + 2:.1f} {y + 26:.1f}h12M{left + 8:.1f} {y + 20:.1f}v12" stroke="{INK}" stroke-width="2"/>'
    yield f'<text x="{left + 23:.1f}" y="{y + 30:.1f}">as it is now</text>'
    yield f'<rect x="{left:.1f}" y="{y + 44:.1f}" width="16" height="16" fill="url(#beyond)"/>'
    yield f'<text x="{left + 23:.1f}" y="{y + 56:.1f}">not possible</text>'
