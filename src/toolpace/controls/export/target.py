"""The interface of an export target: the motion to export, and the files written of it and read back against the plan.

The motion comes with machine, program and checksums, and is told of at the head of files.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from toolpace.common import __version__
from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, VerificationError, printable
from toolpace.common.files import changed, reason
from toolpace.common.units import DEGREE, MILLIMETRE, format_angle, format_length, format_time
from toolpace.machine.machine import Machine
from toolpace.motion.set_point_files import read_set_points
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.reading import ReadOptions, Source
from toolpace.results.write import MACHINE, PLAN, PlanRecord, read_again, read_plan, refuse_without_set_points

USUAL = (0.01 * MILLIMETRE, 0.05 * DEGREE)
"""Tolerances of tip [m] and tool axis [rad] that plans have where no others are given."""


@dataclass(frozen=True)
class PlannedMotion:
    """Set-points with all that an export says of them."""

    setpoints: SetPoints
    machine: Machine
    name: str
    """Of the plan, for messages."""
    program: str = ""
    """Name of the program; empty where it is not known."""
    duration: float = math.nan
    """[s]"""
    source: Source | None = None
    """The program as it was read; None where there is none."""
    record: PlanRecord | None = None
    """plan.json; None for a trajectory that was never written."""
    options: ReadOptions = field(default_factory=ReadOptions)
    """How the program was read."""
    sha256: Mapping[str, str] = field(default_factory=dict)
    """Checksums of the machine file and of the program."""

    @property
    def dt(self) -> float:
        """Time between set-points [s]."""
        t = self.setpoints.t
        return float(t[1] - t[0])

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.setpoints.joints

    @property
    def rotary(self) -> tuple[bool, ...]:
        """Whether each joint turns."""
        return tuple(bool(each) for each in self.machine.is_rotary)

    @property
    def tolerances(self) -> tuple[float, float]:
        """How far the plan may stray, by tip [m] and tool axis [rad]; the usual where it was not told."""
        tip = None if self.record is None else self.record.tip_tolerance_mm
        axis = None if self.record is None else self.record.axis_tolerance_deg
        return tip * MILLIMETRE if tip else USUAL[0], axis * DEGREE if axis else USUAL[1]

    @property
    def shop_units(self) -> tuple[list[str], Floats]:
        """Unit of each joint, mm or deg, and the factors (m,) that make it of m and rad."""
        units = ["deg" if turns else "mm" for turns in self.rotary]
        return units, np.array([math.degrees(1.0) if turns else 1e3 for turns in self.rotary])

    def by_joint(self, values: Floats) -> str:
        """ "X 3 µm, A 0.001 deg": what each joint (m,) is off by, or moves by [m, rad]."""
        show = [format_angle if turns else format_length for turns in self.rotary]
        return ", ".join(f"{joint} {text(value)}" for joint, text, value in zip(self.joints, show, values))

    @classmethod
    def of(cls, trajectory: Trajectory, dt: float) -> PlannedMotion:
        """A trajectory sampled every `dt` [s]. Raises UsageError where it was planned without a machine."""
        machine = trajectory.axis_path.machine
        if machine is None:
            raise UsageError(
                "export: the trajectory was planned without a machine, so that no unit is known; plan on one"
            )
        points = trajectory.sample(dt)
        return cls(points, machine, "trajectory", duration=trajectory.duration, sha256={"machine": _sha(machine)})

    @classmethod
    def load(cls, folder: Path) -> PlannedMotion:
        """The plan in a folder, refused where a file was changed, where it has no set-points, or was found wanting.

        Raises UsageError.
        """
        try:
            found = folder.is_dir()
        except OSError:
            found = False
        if not found:
            raise UsageError(f"{folder}: no such folder; give the one that `toolpace plan` wrote")
        for name in (PLAN, MACHINE):
            if not (folder / name).is_file():
                raise UsageError(f"{folder}: holds no file {name}; give the folder that `toolpace plan` wrote")
        record = read_plan(folder)
        try:
            words = changed(folder)
        except OSError as error:
            raise UsageError(f"{folder}: cannot read: {reason(error)}") from None
        if words:
            raise UsageError(f"{folder}: {words}; plan again, so that what is exported is what was planned")
        if record.verified is False:
            raise UsageError(
                f"{folder}: its verification failed, and a motion that exceeds a limit is not exported; "
                f"`toolpace verify {folder}` says where"
            )
        refuse_without_set_points(folder, "exported")
        machine = Machine.load(folder / MACHINE)
        source = Source.load(folder / record.program_file) if record.program_file else None
        return cls(
            read_set_points(folder, machine),
            machine,
            str(folder),
            record.program,
            record.duration_s,
            source,
            record,
            read_again(folder, record.reading),
            {"machine": _file_sha(folder / MACHINE)}
            | ({"program": hashlib.sha256(source.data).hexdigest()} if source else {}),
        )


def _sha(machine: Machine) -> str:
    return hashlib.sha256(machine.to_toml().encode()).hexdigest()


def _file_sha(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


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
