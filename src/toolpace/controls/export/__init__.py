"""Exports of a plan: tables, LinuxCNC streams, FIFO rows, or the program with new feeds.

Each export is a folder, whole or not at all, with a seal by which it is known as one that toolpace wrote; every file in
it says how it is used, and was read back and compared with the plan before the folder took its place.
"""

from __future__ import annotations

import dataclasses
import importlib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from toolpace.common import __version__
from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.common.files import whole_folder
from toolpace.controls.export.target import PlannedMotion, ReadBack, Target, Written
from toolpace.motion.trajectory import Trajectory

__all__ = [
    "EXPORT", "TARGETS", "ExportRecord", "Exported", "PlannedMotion", "ReadBack", "Target", "Written", "export",
    "target_of", "write_export",
]  # fmt: skip

EXPORT = "export.json"
"""Its name in the folder of an export."""
TARGETS = {
    "table": ("table", "Table"),
    "linuxcnc-hal": ("linuxcnc.streamer_files", "Streamer"),
    "linuxcnc-g93": ("linuxcnc.inverse_time", "InverseTime"),
    "beckhoff-fifo": ("fifo", "Fifo"),
    "program": ("program", "Program"),
}
"""Name to the module and the class that write it; a module is imported when it is asked for."""


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


@dataclass(frozen=True)
class Exported:
    """What an export left on disk."""

    folder: Path
    files: tuple[str, ...]
    """Names in the folder, the one to load first."""
    notes: tuple[str, ...]
    """Sentences: what was assumed, and how exact it is."""
    checks: tuple[ReadBack, ...]
    """How the files compare with the plan, read back."""


def export(
    plan: str | os.PathLike[str] | Trajectory,
    to: str,
    out: str | os.PathLike[str],
    dt: float = 1e-3,
    **options: Any,
) -> Exported:
    """Write a plan for a control, into a folder that is whole or not there.

    plan: the folder of a plan, or a trajectory, which is sampled every `dt` [s].
    to: `table`, `linuxcnc-hal`, `linuxcnc-g93`, `beckhoff-fifo` or `program`; the last needs a folder.
    out: the folder; replaced only where toolpace wrote all that is in it.
    options: those of the command, with times in seconds: period=4e-3, columns=("t", "q"), counts={"X": "10000/mm"}, ...

    Raises UsageError where the target cannot hold the plan, VerificationError where what was written reads differently.
    """
    target = target_of(to, options)
    motion = PlannedMotion.of(plan, dt) if isinstance(plan, Trajectory) else PlannedMotion.load(Path(plan))
    return write_export(motion, target, out)


def target_of(name: str, options: dict[str, Any]) -> Target:
    """The target of a name with its options. Raises UsageError where there is none, or not such an option."""
    if name not in TARGETS:
        raise UsageError(f"--to {str(name)[:40]}: there is no such target; {did_you_mean(str(name), TARGETS)}")
    module, kind = TARGETS[name]
    made = getattr(importlib.import_module(f"toolpace.controls.export.{module}"), kind)
    options_of_target = [each.name for each in dataclasses.fields(made)]
    for option in options:
        if option not in options_of_target:
            shown = ", ".join(f"--{each.replace('_', '-')}" for each in options_of_target)
            raise UsageError(f"--{option.replace('_', '-')} is no option of --to {name}; it has {shown}")
    target: Target = made(**options)
    return target


def write_export(
    motion: PlannedMotion,
    target: Target,
    out: str | os.PathLike[str],
    progress: Callable[[float], None] | None = None,
) -> Exported:
    """Write the folder of an export, read it back, and put it in its place; `progress` is told the share done."""
    tell = progress or (lambda share: None)
    with whole_folder(out, seal=EXPORT) as folder:
        tell(0.0)
        written = target.write(motion, folder)
        tell(0.6)
        checks = target.check(motion, folder, written)
        tell(0.95)
        write_record(folder, motion, target, written, checks)
    return Exported(Path(out), (*written.files, EXPORT), tuple(written.notes), tuple(checks))


def write_record(
    folder: Path, motion: PlannedMotion, target: Target, written: Written, checks: Sequence[ReadBack]
) -> None:
    """Write export.json into the folder of an export; the seal comes with the folder."""
    assert dataclasses.is_dataclass(target)
    options = {
        each.name: printable(str(getattr(target, each.name)))
        for each in dataclasses.fields(target)
        if getattr(target, each.name) not in (each.default, None, {}, ())
    }
    record = ExportRecord(
        target=target.name,
        options=options,
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
