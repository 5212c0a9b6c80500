"""The page of a set-up search."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from toolpace.common import __version__
from toolpace.common.units import DEGREE, MILLIMETRE, format_time
from toolpace.results.report.place_map import map_svg
from toolpace.results.report.shell import framed
from toolpace.results.report.words import NEUTRAL, at_most, colours, limit_words, percent

if TYPE_CHECKING:
    from toolpace.setup_search.search_result import FoundSetUp
    from toolpace.setup_search.verified_set_up import PlannedSetUp

SHARES = 12
"""Limits that are shown at most."""
SHOWN = 5e-3
"""Share of the time below which a limit is not, before and after."""
STYLE = """
.n { text-align: right; white-space: nowrap; } tr.given td { background: #f4f6f9; } tr.first td { font-weight: 640; }
.both .bar { padding: 1px 0; } .both .after { margin-bottom: 8px; } .both .before .fill { opacity: 0.45; }
.both .before .share { opacity: 0.7; } pre { overflow-x: auto; font-size: 12.5px; margin: 0; }
svg { max-width: 100%; height: auto; }
"""


def set_up_page(
    found: FoundSetUp, program: str, sheet: str, others: Sequence[tuple[str, FoundSetUp | str]] = ()
) -> str:
    """The whole HTML text.

    sheet: the text of the set-up sheet. others: all machines that were searched, with what was found or why nothing.
    """
    best = found.best[0]
    machine = escape(best.machine.name)
    parts = [
        f"<header><div><h1>{escape(program)}</h1><p>where to clamp the part on <b>{machine}</b></p></div></header>",
        "<main>",
        f'<section class="cards">{_cards(found)}</section>',
        _machines(others),
        _panel("The best set-ups", "each planned in full, within all travels", _table(found)),
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
    return framed(f"Set-up for {program} on {best.machine.name}", "\n".join(parts), STYLE)


def _panel(title: str, lead: str, body: str) -> str:
    if not body:
        return ""
    return f'<section class="panel"><h2>{escape(title)}</h2><p class="lead">{escape(lead)}</p>{body}</section>'


def _cards(found: FoundSetUp) -> str:
    best, given = found.best[0], found.given
    cards = [("Time", format_time(best.duration), best.clamping.words(best.machine), "big")]
    if given is not None:
        saved = given.duration - best.duration
        cards.append(("Gain", percent(found.gain), f"{format_time(saved)} of {format_time(given.duration)}", ""))
    else:
        cards.append(("As given", "cannot be run", found.why, ""))
    cards.append(("Gap", at_most(best.gap), "of the best set-up: its time over the lower bound on its mesh", ""))
    cards.append(("Tried", f"{found.trials}", f"clampings, in {format_time(found.seconds)}", ""))
    return "".join(
        f'<div class="card {kind}"><div class="label">{escape(label)}</div><div class="value">{escape(value)}</div>'
        f'<div class="note">{escape(note)}</div></div>'
        for label, value, note, kind in cards
    )


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
        for name, found in sorted(others, key=_time)
    )
    head = "<th>Machine</th><th class=n>Time</th><th class=n>As given</th><th class=n>Gain</th><th>Set-up</th>"
    body = f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
    return _panel("Machines", "each with its own best set-up; this page is of the fastest", body)


def _time(machine: tuple[str, FoundSetUp | str]) -> float:
    return math.inf if isinstance(machine[1], str) else machine[1].best[0].duration


def _gain(each: PlannedSetUp, given: PlannedSetUp | None) -> str:
    return percent(1.0 - each.duration / given.duration) if given is not None and each is not given else ""


def _table(found: FoundSetUp) -> str:
    names = ("", "Time", "Gain", "Gap", "Turn", "Tilt", "Swing", "X", "Y", "Z", "Tool", "Solution")
    head = "".join(f"<th{' class=n' if i else ''}>{name}</th>" for i, name in enumerate(names))
    shown = [*found.best, *([found.given] if found.given is not None and found.given not in found.best else [])]
    rows = "".join(_row(k, each, found.given) for k, each in enumerate(shown, start=1))
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


def _row(number: int, each: PlannedSetUp, given: PlannedSetUp | None) -> str:
    clamping = each.clamping
    cells = [format_time(each.duration), _gain(each, given), at_most(each.gap)]
    cells += [_figure(angle / DEGREE) for _, angle in clamping.angles()]
    cells += [_figure(shift / MILLIMETRE) for shift in clamping.shift]
    tools = ", ".join(_figure(length / MILLIMETRE) for length in each.tool_lengths)
    cells += [tools, {0: "free", 1: "+", -1: "-"}[clamping.side]]
    kind = "given" if each is given else "first" if number == 1 else ""
    label = "as given" if each is given else f"{number}"
    return f'<tr class="{kind}"><td>{label}</td>' + "".join(f"<td class=n>{cell}</td>" for cell in cells) + "</tr>"


def _figure(value: float) -> str:
    return f"{round(value, 2) + 0.0:g}"


def _map(found: FoundSetUp) -> str:
    return map_svg(found.places) if found.places is not None else ""


def _limits(found: FoundSetUp) -> str:
    palette = colours(found.best[0].machine.joints)
    changes = {name: both for name, both in found.changes().items() if max(both) >= SHOWN}
    top = max((max(both) for both in changes.values()), default=1.0)
    rows = (_bars(name, both, top, palette) for name, both in list(changes.items())[:SHARES])
    return f'<div class="bars both">{"".join(rows)}</div>'


def _bars(name: str, both: tuple[float, float], top: float, palette: Mapping[str, str]) -> str:
    colour = palette.get(name, NEUTRAL)
    return "".join(
        f'<div class="bar {kind}"><span class="name">{escape(label)}</span><span class="track"><span class="fill" '
        f'style="width:{100.0 * share / top:.2f}%;background:{colour}"></span></span>'
        f'<span class="share">{percent(share)}</span></div>'
        for kind, label, share in (("before", limit_words(name), both[0]), ("after", "", both[1]))
    )
