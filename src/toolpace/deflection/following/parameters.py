"""Checked parameters of a follower."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats


def numbers(given: object) -> Floats | None:
    """What was given as an array of real numbers, or None where it is none: text, truth values and None are none."""
    try:
        found = np.asarray(given)
    except (TypeError, ValueError, OverflowError):
        return None
    return found.astype(float) if found.dtype.kind in "iuf" else None


def number(given: object) -> float | None:
    """What was given as one real number, or None where it is none."""
    found = numbers(given)
    return None if found is None or found.shape != () else float(found)
