"""Diverse selection: the best trials that differ from each other."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from toolpace.setup_search.clamping import Clamping
from toolpace.setup_search.trial import Trial

TURNED = math.radians(5.0)
"""From which turn on two directions are unlike [rad]."""
MOVED = 20e-3
"""From which distance on two places are unlike [m]; only where there are too few directions."""


def diverse_ones(best: Trial, trials: Sequence[Trial], most: int) -> list[Trial]:
    """The best, and the next of trials that fit: of unlike directions or tools first, then of unlike places."""
    if not best.fits:
        return []
    ranked = sorted((trial for trial in trials if trial.fits), key=lambda trial: trial.cost)
    chosen = [best]
    for moved in (math.inf, MOVED):
        for trial in ranked:
            if len(chosen) == most:
                break
            if all(_differ(trial.clamping, other.clamping, moved) for other in chosen):
                chosen.append(trial)
    return sorted(chosen, key=lambda trial: trial.cost)


def _differ(a: Clamping, b: Clamping, moved: float) -> bool:
    if a.side != b.side or a.tool_length != b.tool_length:
        return True
    # the angle of the turn from one to the other
    cosine = 0.5 * (float(np.trace(a.rotation.T @ b.rotation)) - 1.0)
    return math.acos(min(max(cosine, -1.0), 1.0)) >= TURNED or math.dist(a.shift, b.shift) >= moved
