# ruff: noqa: RUF001 - primes and minus signs, as formulas are set
"""Figures 1 to 3, drawn from the paper's text and equations."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.study.drawings import MARK
from toolpace.study.svg import FILL, INK, SOFT, Drawing

TOOL, PART, GROUND, CHAIN = "#d9622b", "#2563c9", "#5b6778", "#0f8a6a"
"""Colours of what carries the tool, of what carries the workpiece, of the frame between, and of the loop."""


@dataclass(frozen=True)
class Sketch:
    """A figure that shows no result."""

    number: int
    title: str
    caption: str
    svg: str


def all_sketches() -> tuple[Sketch, ...]:
    """Figures 1 to 3."""
    return (
        Sketch(1, "Machine, frames, and the closed chain",
               "Eq. (1) to (5) with the errata applied, in a pose with A and B turned; lengths are not to scale. X and"
               " Y ride on the table that B turns, Z and A carry the tool. Tip and point of the curve are one: that"
               " closes the chain.", closed_chain().svg()),
        Sketch(2, "Algorithm without deflection, in the i-th interval",
               "The periods are bred interval by interval; the speeds at the points are set before.",
               flow_chart().svg()),
        Sketch(3, "Path with a deflection, and the field that finds its projection",
               "Circles are equal potential about the deflection, Eq. (10). The target slides along the path until the"
               " attraction has no component left along it. Not to scale.", deflected_path().svg()),
    )  # fmt: skip


def seen(points: Floats) -> Floats:
    """(n, 2) pixels of points (n, 3) of the machine: x to the right, y to the back, z up."""
    out: Floats = np.array([250.0, 375.0]) + points @ np.array([[1.0, 0.10], [0.50, -0.36], [0.0, -1.0]])
    return out


def closed_chain() -> Drawing:
    """Figure 1; the pose is one of the machine's, by Eq. (2) and (3)."""
    out = Drawing(940, 450, "Frames of the machine and the closed chain of tool and workpiece")
    a, b, tool, height, rise = np.radians(35.0), np.radians(-14.0), 135.0, 315.0, 34.0
    turn = np.array([[np.cos(b), 0.0, np.sin(b)], [0.0, 1.0, 0.0], [-np.sin(b), 0.0, np.cos(b)]])
    ground, pivot = np.zeros(3), np.array([0.0, 0.0, height])
    tip = np.array([0.0, tool * np.sin(a), height - tool * np.cos(a)])
    touched = turn.T @ tip
    origin = np.array([touched[0] + 195.0, touched[1] - 75.0, rise])
    part = turn @ origin

    def on_table(points: Floats | list[tuple[float, float, float]]) -> Floats:
        return seen(np.array(points) @ turn.T)

    x, y, _ = origin
    out.area(on_table([(-120, -70, 0), (250, -70, 0), (250, 130, 0), (-120, 130, 0)]), PART, 0.10, PART)
    low, high = (x - 230, y - 10), (x + 35, y + 130)
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    out.area(on_table([(*corner, rise) for corner in corners]), PART, 0.18, PART)
    out.area(seen(np.stack([ground, pivot, tip, part])), CHAIN, 0.10)
    bend = np.linspace(-0.8, 0.9, 40)
    curve = np.stack([touched[0] + 90 * bend, touched[1] + 20 * bend, touched[2] - 45 * bend**2], axis=1)
    out.line(on_table(curve), INK, 2.2)
    axes(out, ground, np.eye(3), GROUND, ("x_lg", "y_lg", "z_lg"), 75.0)
    axes(out, part, turn, PART, ("x_w", "y_w", "z_w"), 62.0)
    out.line(seen(np.stack([ground, pivot])), TOOL, 1.6, dash=True)
    out.line(seen(np.stack([pivot, tip])), TOOL, 5.0)
    out.line(seen(np.stack([ground, part])), PART, 1.6, dash=True)
    out.line(seen(np.stack([part, tip])), CHAIN, 2.0, arrow=True)
    for place, colour in ((ground, GROUND), (pivot, TOOL), (part, PART), (tip, MARK)):
        out.circle(seen(place[None])[0], 4.5, colour, colour)
    label(out, pivot, (12, -6), "A about x; Z carries it", TOOL)
    label(out, 0.6 * pivot, (-10, 0), "z₁ + z_gt", TOOL, "end")
    label(out, 0.5 * (pivot + tip), (12, 0), "tool, l_t", TOOL)
    label(out, tip, (14, -12), "tip = point of the system curve", MARK)
    label(out, ground, (-12, 18), "B about y", GROUND, "end")
    label(out, 0.62 * part, (0, 20), "x, y, z₂, turned by B", PART)
    label(out, 0.45 * part + 0.55 * tip, (12, -2), "P_w", CHAIN)
    for k, (text, colour) in enumerate((
        ("lower ground", GROUND), ("→ Z slide, z_gt → A → tool, l_t", TOOL), ("→ tip: P_t^w = P_w", MARK),
        ("← workpiece ← Y slide ← X slide ← B table", PART), ("← lower ground", GROUND),
    )):  # fmt: skip
        out.words((625, 60 + 24 * k), text, colour, bold=k in (0, 2, 4))
    for k, text in enumerate((
        "The shaded loop is closed at every instant:", "five motors for three coordinates of the tip",
        "and two angles of the tool.",
    )):  # fmt: skip
        out.words((625, 206 + 20 * k), text, SOFT)
    return out


def axes(out: Drawing, origin: Floats, turn: Floats, colour: str, names: tuple[str, ...], length: float) -> None:
    """The arrows of a frame."""
    for direction, name in zip(turn.T, names):
        end = seen(np.stack([origin, origin + length * direction, origin + (length + 14.0) * direction]))
        out.line(end[:2], colour, 1.4, arrow=True)
        out.words(end[2], name, colour, off=(0, 4), anchor="middle", size=12)


def label(out: Drawing, place: Floats, off: tuple[float, float], text: str, colour: str, anchor: str = "start") -> None:
    """Words beside a point of the machine."""
    out.words(seen(place[None])[0], text, colour, off=off, anchor=anchor)


def flow_chart() -> Drawing:
    """Figure 2."""
    out = Drawing(940, 690, "Flow chart of the genetic algorithm in one interval")
    centre, wide = 330.0, 430.0
    steps = [
        (40, ("Reference points P_i and P_i+1", "x_w, y_w, z_w, A, B with r′ and r″; preset speed and acceleration")),
        (130, ("Quintic of the interval, Eq. (7a, 7b)", "C₀ to C₅ of each coordinate in u")),
        (220, ("First population of periods T_i", "random genes, and one period known to pass")),
        (310, ("Motion over each T_i, Eq. (7c, 7d)", "u(t), du/dt, feed rate")),
        (400, ("Motors, Eq. (6, 7e)", "position, velocity, acceleration, jerk")),
        (490, ("Constraints of Eq. (11)", "kept: fitness T_i; broken: a thousand periods and more")),
        (650, ("Shortest T_i that passes", "on to the interval i + 1; T = Σ T_i")),
    ]  # fmt: skip
    for y, words in steps:
        out.box((centre, y), (wide, 54), words)
    for (y, _), (below, _) in pairwise(steps):
        if below < 600:
            out.line([(centre, y + 27), (centre, below - 28)], arrow=True)
    out.area([(centre, 533), (centre + 110, 568), (centre, 603), (centre - 110, 568)], FILL, 1.0, SOFT)
    out.words((centre, 572), "last generation?", anchor="middle")
    out.line([(centre, 517), (centre, 532)], arrow=True)
    out.line([(centre, 603), (centre, 622)], arrow=True)
    out.words((centre + 8, 618), "yes", SOFT)
    out.box(
        (735, 440),
        (310, 76),
        ("Next generation", "tournaments of two, one-point crossover,", "flipped bits; the best lives on"),
    )
    out.line([(centre + 110, 568), (735, 568), (735, 479)], arrow=True)
    out.words((centre + 120, 560), "no (the paper breeds one)", SOFT)
    out.line([(735, 402), (735, 310), (centre + wide / 2 + 1, 310)], arrow=True)
    return out


def deflected_path() -> Drawing:
    """Figure 3: a circle stands for the path, so that the projection is exact."""
    out = Drawing(940, 350, "A deflected path, its projection, and the potential field")
    centre, radius = np.array([430.0, 900.0]), 680.0

    def on_path(degrees: float | Floats, beyond: float = 0.0) -> Floats:
        turn, reach = np.radians(degrees), radius + beyond
        return np.stack([centre[0] + reach * np.sin(turn), centre[1] - reach * np.cos(turn)], axis=-1)

    found, start, foot = on_path(-2.0, 105.0), on_path(8.5), on_path(-2.0)
    for reach in (35.0, 70.0, 105.0, 140.0, 175.0):
        out.circle(found, reach, "#e4c9d3")
    out.line(on_path(np.linspace(-27.0, 29.0, 80)), INK, 2.2)
    for place, name in ((-22.0, "P_i−1"), (-9.0, "P_i"), (17.0, "P_i+1"), (26.5, "P_i+2")):
        out.circle(on_path(place), 4.5, INK, INK)
        out.words(on_path(place, -26.0), name, anchor="middle")
    out.line(deflected_line(on_path(np.linspace(-27.0, -2.0, 60)), found), TOOL, 1.8)
    u = np.linspace(0.0, 1.0, 40)[:, None]
    drop = 10 * u**3 - 15 * u**4 + 6 * u**5
    out.line(found + drop * (foot - found) + u * (1.0 - u) ** 2 * [180.0, 0.0], PART, 2.0, dash=True)
    out.line(on_path(np.linspace(-2.0, 17.0, 30)), PART, 4.0)
    pull = 80.0 * (found - start) / np.linalg.norm(found - start)
    along = on_path(8.5 - 1e-3) - start
    out.line([start, start + pull], CHAIN, 1.8, arrow=True)
    out.line([start, start + along * (pull @ along) / (along @ along)], MARK, 2.4, arrow=True)
    out.circle(start, 4.5, CHAIN, "#ffffff")
    out.circle(found, 5.5, INK, INK)
    out.circle(foot, 5.5, MARK, MARK)
    out.words(found, "deflection p_d", off=(12, -8), bold=True)
    out.words(foot, "projection p_tar", MARK, off=(0, 26), anchor="middle", bold=True)
    out.words(start + pull, "attraction F_att = −∇U", CHAIN, off=(10, 2))
    out.words(start, "target, drawn along the path", MARK, off=(16, -8))
    out.words(on_path(-22.0), "deflected path", TOOL, off=(0, -16), anchor="middle")
    out.words(found, "1st new interval, T_dp", PART, off=(34, 24))
    out.words(on_path(8.5, -62.0), "2nd new interval, to P_i+1", PART, anchor="middle")
    out.words(found, "U = |p_tar − p_d|²", "#b0567a", off=(-184, 4), anchor="end", size=12)
    return out


def deflected_line(path: Floats, found: Floats) -> Floats:
    """(n, 2) beside a path (n, 2), leaving it smoothly in its last quarter for where the tool is found (2,)."""
    share = np.clip(np.linspace(-2.0, 1.0, len(path)), 0.0, 1.0)[:, None] ** 2
    line: Floats = path + (1.0 - share) * [0.0, -5.0] + share * (found - path[-1])
    return line
