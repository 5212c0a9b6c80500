"""Thread pitches, given or by metric size (ISO 261)."""

from __future__ import annotations

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.sinumerik.syntax.values import Unread, ValueFault
from toolpace.programs.reading.sinumerik.word_values import Arguments

COARSE = {
    3: 0.5, 4: 0.7, 5: 0.8, 6: 1.0, 8: 1.25, 10: 1.5, 12: 1.75, 14: 2.0, 16: 2.0, 18: 2.5, 20: 2.5, 22: 2.5, 24: 3.0,
    27: 3.0, 30: 3.5, 33: 3.5, 36: 4.0, 39: 4.0, 42: 4.5, 45: 4.5, 48: 5.0,
}  # fmt: skip
"""Pitch [mm] by nominal diameter [mm]."""
SAME = 1e-9
"""Between pitches that are one [m]."""


def metric_pitch(size: float) -> float:
    """Pitch [m] of the thread M`size`. Raises ValueFault."""
    if size not in COARSE:
        raise ValueFault(f"M{size:g} is no metric size from M3 to M48: write the pitch PIT in place of MPIT")
    return COARSE[int(size)] * MILLIMETRE


def pitch_of(arguments: Arguments, unit: float, *, size: int, pitch: int, kind: int) -> float:
    """Lead of a thread [m], from the places of its metric size, of the pitch itself, and of what that is told in.

    unit: of lengths [m]. Raises ValueFault, Unread.
    """
    by_size = abs(arguments.number(size))
    if not arguments.number(pitch):
        if by_size:
            return metric_pitch(by_size)
        raise ValueFault(
            f"{arguments.name} lacks the pitch of its thread: write MPIT or PIT, argument {size + 1} or {pitch + 1}"
        )
    told_in = arguments.code(kind)
    if told_in not in (0, 1, 3):
        raise Unread(f"{arguments.name} with a pitch in modules or turns per inch", "write it in mm or inch")
    lead = abs(arguments.number(pitch)) * {0: unit, 1: MILLIMETRE, 3: INCH}[told_in]
    if by_size and abs(metric_pitch(by_size) - lead) > SAME:
        raise ValueFault(f"{arguments.name}: MPIT and PIT tell different pitches (alarm 61001): write one of them")
    return lead
