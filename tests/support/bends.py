"""Paths with a bend narrower than any grid, and limits for them, by a generator."""

from __future__ import annotations

import numpy as np

from testbed.jets import harmonics, path_of, straight
from toolpace.machine.limits import Limits


def bend(random: np.random.Generator, width: float, joints: int):
    """A smooth path with a step of tanh somewhere, whose curvature would pass the limits by far at full speed."""
    place = random.uniform(0.05, 0.95)
    base = straight(random.normal(size=joints)) if random.random() < 0.5 else harmonics(random, joints, 3)
    height = random.normal(size=joints) * width * 10.0 ** random.uniform(-2.0, 0.3)

    def jets(s):
        y = np.tanh((s - place) / width)
        g = 1.0 - y * y
        step = np.stack([y, g / width, -2 * y * g / width**2, (6 * y * y - 2) * g / width**3])
        return base(s) + step[:, :, None] * height

    return path_of(jets), place


def limits_of(random: np.random.Generator, joints: int) -> Limits:
    return Limits(
        random.uniform(0.5, 2.0, joints), random.uniform(2.0, 8.0, joints), random.uniform(20.0, 80.0, joints)
    )
