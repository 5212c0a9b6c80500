"""The interface of an export target: write files, read them back against the plan."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Protocol

from toolpace.common.errors import VerificationError
from toolpace.controls.export.motion import PlannedMotion


@dataclass(frozen=True)
class Written:
    """What a target wrote."""

    files: list[str]
    """Names in the folder, the one to load first."""
    notes: list[str] = field(default_factory=list)
    """Sentences for the user: what was assumed, and how exact it is."""


@dataclass(frozen=True)
class ReadBack:
    """What came of reading the files again."""

    what: str
    """What was compared, and in which unit."""
    worst: float
    """Largest difference from the plan."""
    allowed: float
    """The resolution of the file: what rounding alone explains."""

    def __str__(self) -> str:
        return f"{self.what}: {self.worst:.3g}, allowed {self.allowed:.3g}"

    def raise_if_failed(self, file: Path) -> ReadBack:
        """Return itself if the file holds what was planned; else raise VerificationError with the figures."""
        if not self.worst <= self.allowed:
            raise VerificationError(
                f"{file.name}: read back it is not what was planned, {self}; nothing was written; is the disk sound?"
            )
        return self


class Target(Protocol):
    """Writes a plan for one kind of control; its fields are its options, checked when it is made."""

    name: ClassVar[str]

    def write(self, motion: PlannedMotion, folder: Path) -> Written:
        """Write the files into a folder. Raises UsageError where the target cannot hold the plan."""

    def check(self, motion: PlannedMotion, folder: Path, written: Written) -> list[ReadBack]:
        """Read the files again and compare them with the plan. Raises VerificationError with the figure."""
