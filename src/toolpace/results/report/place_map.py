"""The map of a set-up search as SVG: duration over x and y."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.units import format_time

if TYPE_CHECKING:
    from toolpace.setup_search.place_map import PlaceMap

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
            told = "not possible: beyond travel, or forbidden" if np.isnan(seconds) else format_time(seconds)
            parts.append(
                f'<rect x="{a:.2f}" y="{b:.2f}" width="{scale * dx + 0.4:.2f}" height="{scale * dy + 0.4:.2f}" '
                f'fill="{fill}"><title>x {px:.4g}, y {py:.4g} mm: {escape(told)}</title></rect>'
            )
    parts += [*_ticks(x, y, at, TOP + high), *_marks(places, at), *_scale(low, top, LEFT + wide + 26.0, high)]
    return "\n".join([*parts, "</svg>"])


def _span(places: PlaceMap) -> tuple[float, float]:
    """Between which times the colours run [s]."""
    known = places.seconds[np.isfinite(places.seconds)]
    if not len(known):
        return 0.0, 1.0
    low = float(known.min())
    return low, max(float(known.max()), low * (1.0 + FLATTEST))


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
        told = format_time(low + share * (top - low))
        yield f'<text x="{left + 23:.1f}" y="{TOP + tall * (1.0 - share) + 4:.1f}">{told}</text>'
    y = TOP + tall + 36.0
    yield f'<circle cx="{left + 8:.1f}" cy="{y:.1f}" r="7" fill="none" stroke="#d6336c" stroke-width="2.5"/>'
    yield f'<text x="{left + 23:.1f}" y="{y + 4:.1f}">best</text>'
    yield f'<path d="M{left + 2:.1f} {y + 26:.1f}h12M{left + 8:.1f} {y + 20:.1f}v12" stroke="{INK}" stroke-width="2"/>'
    yield f'<text x="{left + 23:.1f}" y="{y + 30:.1f}">as it is now</text>'
    yield f'<rect x="{left:.1f}" y="{y + 44:.1f}" width="16" height="16" fill="url(#beyond)"/>'
    yield f'<text x="{left + 23:.1f}" y="{y + 56:.1f}">not possible</text>'
