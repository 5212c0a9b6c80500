"""Pitches of metric threads by their size (ISO 261, coarse)."""

from __future__ import annotations

from toolpace.reading.sinumerik.syntax.values import ValueFault
from toolpace.units import MILLIMETRE

COARSE = {
    3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2.0, 16: 2.0, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3.0,
    27: 3.0, 30: 3.5, 33: 3.5, 36: 4.0, 39: 4.0, 42: 4.5, 45: 4.5, 48: 5.0,
}  # fmt: skip
"""Pitch [mm] by nominal diameter [mm]."""


def metric_pitch(size: float) -> float:
    """Pitch [m] of the thread M`size`. Raises ValueFault."""
    if size not in COARSE:
        raise ValueFault(f"M{size:g} is no metric size from M3 to M48: write the pitch PIT in place of MPIT")
    return COARSE[int(size)] * MILLIMETRE
