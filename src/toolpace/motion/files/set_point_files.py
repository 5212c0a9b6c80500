"""The set-points of a plan on disk: setpoints.npz, which anybody can read, or setpoints.compact, a thirtieth of it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.motion.files.compact_set_points import read_compact
from toolpace.motion.setpoints import SetPoints

FULL_FILE, COMPACT_FILE, MACHINE = "setpoints.npz", "setpoints.compact", "machine.toml"
"""Names of the files."""
FORMS = ("auto", "full", "compact", "no")
"""How set-points are written; auto: in full where that is small."""
OLD_WORDS = {"all": "full", "none": "no", True: "full", False: "no"}
"""What was said before, and is still understood."""
SMALL = 20e6
"""Most bytes of a file that auto writes in full."""
ROUGHLY = 0.5
"""Bytes of the compact file for each number of a row of the full one, as measured on long programs: 0.3 to 0.4."""


def form_named(name: str, value: str | bool) -> str:
    """One of `FORMS`, by its word or an old one. Raises UsageError, beginning with `name`, for another."""
    form = OLD_WORDS.get(value, value)
    if form not in FORMS:
        raise UsageError(f"{name} {str(value)[:40]}: give {', '.join(FORMS[:-1])} or {FORMS[-1]}")
    return str(form)


def form_of(wanted: str, count: int, joints: int) -> str:
    """ "full", "compact" or "no": what is written of so many set-points where one of `FORMS` is wanted."""
    if wanted != "auto":
        return wanted
    return "full" if full_size(count, joints) <= SMALL else "compact"


def full_size(count: float, joints: int) -> float:
    """Bytes that so many set-points with a tool take in full."""
    return 8.0 * count * (1 + 4 * joints + 6 + 1)


def size_of(form: str, count: float, joints: int) -> float:
    """Bytes that so many set-points take, roughly where they are compact."""
    return {"full": 1.0, "compact": ROUGHLY / 8.0, "no": 0.0}[form] * full_size(count, joints)


def file_of(form: str) -> str:
    """Name of the file of "full" or "compact"; empty of "no"."""
    return {"full": FULL_FILE, "compact": COMPACT_FILE, "no": ""}[form]


def set_points_file(folder: Path) -> str:
    """Name of the file with set-points in the folder of a plan; empty where there is none. UsageError where both are
    there: which of them would be meant?"""
    there: Sequence[str] = [name for name in (FULL_FILE, COMPACT_FILE) if os.path.lexists(folder / name)]
    if len(there) > 1:
        raise UsageError(f"{folder}: holds {FULL_FILE} and {COMPACT_FILE}; plan again, into a new folder")
    return there[0] if there else ""


def read_set_points(folder: str | os.PathLike[str], machine: Machine | None = None) -> SetPoints:
    """The set-points in the folder of a plan, whichever of both files holds them.

    `machine` is that of the folder's machine.toml, which is read where none is given. Raises UsageError where a file is
    missing, damaged, or another thing.
    """
    place = Path(folder)
    if set_points_file(place) != COMPACT_FILE:
        return SetPoints.load(place / FULL_FILE)
    return read_compact(place / COMPACT_FILE, machine or Machine.load(place / MACHINE))
