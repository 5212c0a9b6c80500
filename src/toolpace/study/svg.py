"""SVG drawings: arrows, areas, boxes, text."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
import numpy.typing as npt

INK, SOFT, FILL = "#17202e", "#5b6778", "#f4f6f9"
HEAD, HALF = 9.0, 3.5
"""Length and half the width of an arrow's head [pixels]."""


class Drawing:
    """Elements in the order in which they are drawn, in pixels from the upper left corner."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.width, self.height, self.title = width, height, title
        self.parts: list[str] = []

    def line(
        self,
        points: npt.ArrayLike,
        colour: str = SOFT,
        width: float = 1.4,
        *,
        dash: bool = False,
        arrow: bool = False,
    ) -> None:
        """A line through points (n, 2), with a head at its end if it is an arrow."""
        way = np.asarray(points, dtype=float)
        if arrow:
            along = way[-1] - way[-2]
            along /= np.linalg.norm(along)
            across, foot = HALF * np.array([-along[1], along[0]]), way[-1] - HEAD * along
            self.area([way[-1], foot + across, foot - across], colour)
            way = np.concatenate([way[:-1], [foot]])
        dashes = ' stroke-dasharray="5 4"' if dash else ""
        self.parts.append(
            f'<polyline points="{listed(way)}" fill="none" stroke="{colour}" stroke-width="{width:g}"{dashes}'
            ' stroke-linejoin="round"/>'
        )

    def area(self, points: npt.ArrayLike, colour: str, opacity: float = 1.0, edge: str = "none") -> None:
        """A filled polygon (n, 2)."""
        self.parts.append(
            f'<polygon points="{listed(points)}" fill="{colour}" fill-opacity="{opacity:g}" stroke="{edge}"/>'
        )

    def circle(self, centre: npt.ArrayLike, radius: float, edge: str, fill: str = "none") -> None:
        """A circle."""
        x, y = np.asarray(centre, dtype=float)
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{fill}" stroke="{edge}"/>')

    def words(
        self,
        at: npt.ArrayLike,
        text: str,
        colour: str = INK,
        *,
        off: tuple[float, float] = (0.0, 0.0),
        anchor: str = "start",
        size: int = 13,
        bold: bool = False,
    ) -> None:
        """A line of words whose foot begins `off` a point, or with another anchor ends or has its middle there."""
        x, y = np.add(at, off)
        weight = ' font-weight="600"' if bold else ""
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" fill="{colour}"{weight}>'
            f"{escape(text)}</text>"
        )

    def box(
        self, centre: tuple[float, float], size: tuple[float, float], lines: Sequence[str], edge: str = SOFT
    ) -> None:
        """A box with lines of words in its middle."""
        (x, y), (w, h) = centre, size
        self.parts.append(
            f'<rect x="{x - w / 2:.1f}" y="{y - h / 2:.1f}" width="{w:g}" height="{h:g}" rx="8" fill="{FILL}"'
            f' stroke="{edge}"/>'
        )
        for k, text in enumerate(lines):
            self.words((x, y + 4.5 + 17 * (k - (len(lines) - 1) / 2)), text, anchor="middle", bold=k == 0)

    def svg(self) -> str:
        """The whole, for a page or a file."""
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}"'
            f' height="{self.height}" role="img" font-family="system-ui, Liberation Sans, Arial, sans-serif">'
            f"<title>{escape(self.title)}</title>{''.join(self.parts)}</svg>"
        )


def listed(points: npt.ArrayLike) -> str:
    """Points (n, 2) as SVG lists them."""
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in np.asarray(points, dtype=float))
