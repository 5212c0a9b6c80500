"""The origin of an export, as header lines of its files."""

from __future__ import annotations

from toolpace.common import __version__
from toolpace.common.errors import printable
from toolpace.common.units import format_time
from toolpace.controls.export.motion import PlannedMotion


def provenance(motion: PlannedMotion, what: str) -> list[str]:
    """Lines: what the file is, and of which program and machine, by their checksums."""
    lines = [f"{what}, written by toolpace {__version__}"]
    if motion.program:
        lines.append(f"program {printable(motion.program)}, SHA-256 {motion.sha256.get('program', 'not known')}")
    lines.append(f"machine {printable(motion.machine.name)}, SHA-256 of its file {motion.sha256['machine']}")
    lines.append(f"the motion takes {format_time(motion.duration)} ({motion.duration:.6f} s), from rest to rest")
    return lines


def start_in_words(motion: PlannedMotion) -> str:
    """ "X 0 mm, Y -12.5 mm, A 30 deg": where the motion begins."""
    units, factors = motion.shop_units
    first = motion.setpoints.q[0] * factors
    return ", ".join(f"{joint} {_short(value)} {unit}" for joint, value, unit in zip(motion.joints, first, units))


def _short(value: float) -> str:
    return f"{value + 0.0:.6f}".rstrip("0").rstrip(".")
