"""The record of an export, export.json."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import msgspec

from toolpace.common import __version__
from toolpace.common.errors import printable
from toolpace.controls.export.motion import PlannedMotion
from toolpace.controls.export.target import ReadBack, Target, Written

EXPORT = "export.json"
"""Its name in the folder of an export."""


class ExportRecord(msgspec.Struct, frozen=True, kw_only=True):
    """export.json, key by key."""

    target: str
    options: dict[str, str]
    """As they were given, those that were not left at their defaults."""
    program: str
    machine: str
    sha256: dict[str, str]
    """Of the machine file, and of the program."""
    duration_s: float
    files: list[str]
    """The one to load first."""
    notes: list[str]
    read_back: list[str]
    """What was compared with the plan, the worst difference, and what is allowed."""
    toolpace_version: str


def write_record(
    folder: Path, motion: PlannedMotion, target: Target, written: Written, checks: Sequence[ReadBack]
) -> None:
    """Write export.json into the folder of an export; the seal comes with the folder."""
    assert dataclasses.is_dataclass(target)
    given = {
        each.name: printable(str(getattr(target, each.name)))
        for each in dataclasses.fields(target)
        if getattr(target, each.name) not in (each.default, None, {}, ())
    }
    record = ExportRecord(
        target=target.name,
        options=given,
        program=printable(motion.program),
        machine=printable(motion.machine.name),
        sha256=dict(motion.sha256),
        duration_s=motion.duration,
        files=written.files,
        notes=written.notes,
        read_back=[str(check) for check in checks],
        toolpace_version=__version__,
    )
    (folder / EXPORT).write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=2) + b"\n")
