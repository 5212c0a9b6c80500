"""Random contours: lines and arcs of all sizes, sweeps up to whole circles, corners of all angles."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from random import Random

import numpy as np

R = 4.0
"""Of the tool [mm]."""
TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Element:
    """A line, or an arc about a centre; points are complex numbers [mm]."""

    start: complex
    end: complex
    centre: complex | None = None
    sense: int = 0
    """1 counter-clockwise, -1 clockwise."""
    sweep: float = 0.0
    """[rad]"""

    @property
    def length(self) -> float:
        """[mm]"""
        return abs(self.end - self.start) if self.centre is None else abs(self.start - self.centre) * self.sweep

    def point(self, share: np.ndarray) -> np.ndarray:
        """Places (n,) at shares (n,) of the length, from 0 to 1, or beyond on the same line or circle."""
        if self.centre is None:
            return self.start + (self.end - self.start) * share
        return self.centre + (self.start - self.centre) * np.exp(1j * self.sense * self.sweep * share)

    def along(self, share: np.ndarray) -> np.ndarray:
        """Unit directions (n,) there."""
        if self.centre is None:
            way = self.end - self.start
            return np.full(np.shape(share), way / abs(way))
        spoke = self.point(share) - self.centre
        return 1j * self.sense * spoke / np.abs(spoke)

    def beside(self, share: np.ndarray, side: int) -> np.ndarray:
        """Places (n,) of the centre of a tool that touches it there, at the left (1) or the right (-1)."""
        return self.point(share) + 1j * side * R * self.along(share)

    def distance(self, places: np.ndarray) -> np.ndarray:
        """Of places (n,) from it, with its ends [mm]."""
        ends = np.minimum(np.abs(places - self.start), np.abs(places - self.end))
        if self.centre is None:
            way = (places - self.start) / (self.end - self.start)
            within = (way.real >= 0.0) & (way.real <= 1.0)
            return np.where(within, np.abs(way.imag) * self.length, ends)
        spoke = places - self.centre
        swept = (np.angle(spoke / (self.start - self.centre)) * self.sense) % TURN
        return np.where(swept <= self.sweep, np.abs(np.abs(spoke) - abs(self.start - self.centre)), ends)


@dataclass(frozen=True)
class Contour:
    """Elements, the place that the tool comes from, and the place that it leaves to."""

    side: int
    """1 left, -1 right."""
    entry: complex
    elements: list[Element]
    away: complex


def contour(seed: int) -> Contour:
    """A random one: elements from a third to ten times the radius, or from two and a half times."""
    random = Random(seed)
    side, heading = random.choice([-1, 1]), random.uniform(-3, 3)
    at = _rounded(complex(random.uniform(-9, 9), random.uniform(-9, 9)))
    entry = _rounded(at - cmath.rect(R * random.uniform(1.5, 6), heading + random.uniform(-3.1, 3.1)))
    least = random.choice([0.3, 2.5])
    elements: list[Element] = []
    for _ in range(random.randint(1, 6)):
        size = R * math.exp(random.uniform(math.log(least), math.log(10.0)))
        element = _line(at, size, heading) if random.random() < 0.5 else _arc(random, at, size, heading)
        elements.append(element)
        at, heading = element.end, cmath.phase(complex(element.along(np.array([1.0]))[0]))
        heading += _corner(random)
    away = _rounded(at + cmath.rect(R * random.uniform(1.5, 6), heading + random.uniform(-1, 1)))
    return Contour(side, entry, elements, away)


def _line(at: complex, size: float, heading: float) -> Element:
    return Element(at, _rounded(at + cmath.rect(size, heading)))


def _arc(random: Random, at: complex, size: float, heading: float) -> Element:
    sense = random.choice([-1, 1])
    centre = _rounded(at + cmath.rect(size, heading + sense * math.pi / 2))
    if random.random() < 0.1:
        return Element(at, at, centre, sense, TURN)
    sweep = random.choice([random.uniform(0.02, 6.26), random.uniform(0.3, 2.6)])
    return Element(at, centre + (at - centre) * cmath.exp(1j * sense * sweep), centre, sense, sweep)


def _corner(random: Random) -> float:
    """By how much the contour turns: not at all, hardly, to a side, or by any angle [rad]."""
    kind = random.random()
    if kind < 0.2:
        return 0.0
    if kind < 0.3:
        return random.uniform(-0.02, 0.02)
    return random.choice([-1, 1]) * random.uniform(0.05, 1.6) if kind < 0.8 else random.uniform(-3.1, 3.1)


def _rounded(point: complex) -> complex:
    return complex(round(point.real, 6), round(point.imag, 6))
