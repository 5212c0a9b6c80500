"""A five-axis machine: joint chains from the bed to the workpiece and to the tool, limits and travel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from toolpace.arrays import Bools, Floats, Ints
from toolpace.description import one_line
from toolpace.equality import ByValue
from toolpace.errors import MachineError, UsageError, did_you_mean
from toolpace.machine.file import MachineFile, read_machine, write_machine
from toolpace.machine.geometry import Geometry, chain_geometry
from toolpace.machine.limits import Limits
from toolpace.toolpath import ToolPath

__all__ = ["Limits", "Machine"]

FOLDER = Path(__file__).parent / "builtin"
POLE = 1e-9
"""Sine of the angle between tool axis and pole below which the first rotary joint counts as free."""


@dataclass(frozen=True, eq=False, repr=False)
class Machine(ByValue):
    """Three linear and two rotary joints in any order, closed-form kinematics, limits and travel.

    Built-in machines come from `Machine.load(name)`, own ones from a TOML file. Arrays are in SI units;
    tips and tool axes are in the workpiece frame; joint arrays have one column a joint, in the order of
    `joints`.
    """

    file: MachineFile
    """The figures of the machine file, in SI units."""
    source: str = field(default="", compare=False)
    """The file, for messages."""
    name: str = field(init=False)
    joints: tuple[str, ...] = field(init=False)
    """Names of the joints, in the order of the file; columns of joint arrays."""
    kind: str = field(init=False)
    """"table-table", "head-table" or "head-head"."""
    is_rotary: Bools = field(init=False)
    """(m,)"""
    rotary: Ints = field(init=False)
    """(2,) columns of the rotary joints, nearest the workpiece first; rotary arrays are in this order."""
    linear: Ints = field(init=False)
    """(3,) columns of the linear joints."""
    limits: Limits = field(init=False)
    travel: Floats = field(init=False)
    """(m, 2) lowest and highest position [m or rad]; infinite where the joint wraps."""
    wrap: Bools = field(init=False)
    """(m,) whether the joint turns without end."""
    tool_length: float = field(init=False)
    """From the spindle nose to the tip [m]."""
    geometry: Geometry = field(init=False, compare=False)
    """The chain as plain arrays, for the compiled functions."""

    def __post_init__(self) -> None:
        file = self.file
        values = list(file.joints.values())
        geometry, kind = chain_geometry(file, self.source or file.name)
        travel = np.array([joint.travel or (-math.inf, math.inf) for joint in values])
        derived = {
            "name": file.name,
            "joints": tuple(file.joints),
            "kind": kind,
            "is_rotary": np.array([joint.kind == "rotary" for joint in values]),
            "rotary": geometry.place[:2].copy(),
            "linear": geometry.place[2:].copy(),
            "limits": Limits(
                [joint.velocity for joint in values],
                [joint.acceleration for joint in values],
                [joint.jerk for joint in values],
                tuple(file.joints),
            ),
            "travel": travel,
            "wrap": np.array([joint.wrap for joint in values]),
            "tool_length": file.chain.tool_length,
            "geometry": geometry,
        }
        for key, value in derived.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            object.__setattr__(self, key, value)

    @staticmethod
    def names() -> tuple[str, ...]:
        """Names of the built-in machines."""
        return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))

    @classmethod
    def load(cls, name_or_path: str | Path) -> Machine:
        """A built-in machine by name, or one from a TOML file. Raises MachineError."""
        given = str(name_or_path)
        built_in = FOLDER / f"{given}.toml"
        path = built_in if given in cls.names() else Path(given)
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            if path.suffix == ".toml" or path.exists():
                reason = getattr(error, "strerror", None) or "not a text file"
                raise MachineError(f"machine file {given}: {reason}") from None
            known = ", ".join(cls.names())
            close = did_you_mean(given, cls.names())
            hint = f"{close} " if close.startswith("did") else ""
            raise MachineError(
                f"unknown machine '{given}'; {hint}built-in: {known}; or give the path of a .toml file"
            ) from None
        return cls.from_toml(text, given)

    @classmethod
    def from_toml(cls, text: str, source: str = "machine file") -> Machine:
        """A machine from the text of a file; `source` names it in messages. Raises MachineError."""
        return cls(read_machine(text, source), source)

    def to_toml(self) -> str:
        """The text of a machine file that loads to exactly this machine."""
        return write_machine(self.file)

    def mounted(
        self,
        origin: Sequence[float] | None = None,
        x: Sequence[float] | None = None,
        z: Sequence[float] | None = None,
    ) -> Machine:
        """The machine with the part mounted elsewhere: origin [m] and directions, bed frame, joints zero."""
        return self._with_chain(workpiece_origin=origin, workpiece_x=x, workpiece_z=z)

    def with_tool(self, length: float) -> Machine:
        """The machine with a tool of another length [m]."""
        return self._with_chain(tool_length=length)

    def with_limits(self, limits: Limits) -> Machine:
        """The machine with other limits; `limits` has its joints in the same order."""
        if len(limits) != len(self.joints):
            raise UsageError(f"limits of {len(limits)} joints given, machine {self.name} has {len(self.joints)}")
        import msgspec

        values = zip(self.file.joints.items(), limits.velocity, limits.acceleration, limits.jerk)
        joints = {
            name: msgspec.structs.replace(joint, velocity=float(v), acceleration=float(a), jerk=float(j))
            for (name, joint), v, a, j in values
        }
        return replace(self, file=msgspec.structs.replace(self.file, joints=joints))

    def _with_chain(self, **changes: object) -> Machine:
        import msgspec

        given = {key: value for key, value in changes.items() if value is not None}
        chain = msgspec.structs.replace(self.file.chain, **given)
        return replace(self, file=msgspec.structs.replace(self.file, chain=chain))

    def forward(self, q: Floats) -> tuple[Floats, Floats]:
        """Joint positions (n, m) to tips (n, 3) [m] and unit tool axes (n, 3)."""
        from toolpace.kernels.kinematics import chain

        q = np.ascontiguousarray(q, dtype=float)
        tip, axis = np.empty((len(q), 3)), np.empty((len(q), 3))
        chain.forward(self.geometry.frame, self.geometry.group, self.geometry.place, q, tip, axis)
        return tip, axis

    def axis_at(self, rotary: Floats) -> Floats:
        """Rotary positions (n, 2) [rad] to unit tool axes (n, 3)."""
        from toolpace.kernels.kinematics import chain

        rotary = np.ascontiguousarray(rotary, dtype=float)
        axis = np.empty((len(rotary), 3))
        chain.axes(self.geometry.frame, rotary, axis)
        return axis

    def rotary_solutions(self, axis: Floats, pole_tolerance: float = POLE) -> tuple[Floats, Bools]:
        """Tool axes (n, 3) to both rotary solutions (n, 2, 2) [point, solution, joint] and pole (n,).

        Angles lie in [-pi, pi]; nan where no angles, whatever the travel, give the axis. At the pole the
        first rotary joint is free; it is returned as zero there.
        """
        from toolpace.kernels.kinematics import chain

        axis = np.ascontiguousarray(axis, dtype=float)
        solutions, pole = np.empty((len(axis), 2, 2)), np.empty(len(axis), dtype=np.bool_)
        chain.rotary_solutions(self.geometry.frame, pole_tolerance, axis, solutions, pole)
        return solutions, pole

    def joints_at(self, tip: Floats, rotary: Floats) -> Floats:
        """Tips (n, 3) and rotary positions (n, 2) to joint positions (n, m), whatever their travel."""
        from toolpace.kernels.kinematics import chain

        tip, rotary = np.ascontiguousarray(tip, dtype=float), np.ascontiguousarray(rotary, dtype=float)
        q = np.empty((len(tip), len(self.joints)))
        geometry = self.geometry
        self._check_singular(chain.joints_at(geometry.frame, geometry.group, geometry.place, tip, rotary, q), rotary)
        return q

    def linear_jets(self, tip: Floats, rotary: Floats) -> Floats:
        """Derivatives 0..3 of tip (4, n, 3) and rotary joints (4, n, 2) to those of all joints (4, n, m)."""
        from toolpace.kernels.kinematics import jets

        tip, rotary = np.ascontiguousarray(tip, dtype=float), np.ascontiguousarray(rotary, dtype=float)
        q = np.empty((4, tip.shape[1], len(self.joints)))
        geometry = self.geometry
        bad = jets.linear_jets(geometry.frame, geometry.group, geometry.place, tip, rotary, q)
        self._check_singular(bad, rotary[0])
        return q

    def rotary_jets(self, axis: Floats, rotary: Floats) -> Floats:
        """Derivatives 0..3 of the tool axis (4, n, 3) to those of the rotary joints (4, n, 2) near `rotary`.

        At the pole the first rotary joint keeps its given position and rests. nan where the axis cannot be
        reached, and in the derivatives where it lies on the edge of reach.
        """
        from toolpace.kernels.kinematics import jets

        axis, rotary = np.ascontiguousarray(axis, dtype=float), np.ascontiguousarray(rotary, dtype=float)
        out = np.empty((4, axis.shape[1], 2))
        jets.rotary_jets(self.geometry.frame, POLE, axis, rotary, out)
        return out

    def axis_jets(self, rotary: Floats) -> Floats:
        """Derivatives 0..3 of the rotary joints (4, n, 2) to those of the tool axis (4, n, 3)."""
        from toolpace.kernels.kinematics import jets

        rotary = np.ascontiguousarray(rotary, dtype=float)
        out = np.empty((4, rotary.shape[1], 3))
        jets.axis_jets(self.geometry.frame, rotary, out)
        return out

    def tip_lever(self, tip: Floats, rotary: Floats) -> Floats:
        """(n, 2) most motion of a linear joint per unit of each rotary joint while the tip stands [m/rad]."""
        still, turning = np.zeros((4, len(tip), 3)), np.zeros((4, len(tip), 2))
        still[0], turning[0] = tip, rotary
        lever = np.empty((len(tip), 2))
        for joint in range(2):
            turning[1] = 0.0
            turning[1, :, joint] = 1.0
            lever[:, joint] = np.abs(self.linear_jets(still, turning)[1][:, self.linear]).max(axis=1)
        return lever

    def choose_rotary(self, toolpath: ToolPath, pole_tolerance: float = 1e-4) -> Floats:
        """Rotary positions (n, 2) [rad] along a tool path, unwound; see machine/inverse.py. Raises ReachError."""
        from toolpace.machine.inverse import choose_rotary

        return choose_rotary(self, toolpath, pole_tolerance)

    def check_travel(self, q: Floats, block: Ints) -> None:
        """Raise ReachError where joint positions (n, m) leave the travel; `block` (n,) are line numbers."""
        from toolpace.machine.refusals import check_travel

        check_travel(self, q, block)

    def _check_singular(self, point: int, rotary: Floats) -> None:
        if point >= 0:
            from toolpace.machine.refusals import singular_pose

            raise singular_pose(self, rotary[point])

    def summary(self) -> list[dict[str, str]]:
        """One row a joint, in mm and deg: machine, class, joint, kind, carries, travel, limits."""
        from toolpace.machine.table import rows

        return rows(self)

    def __repr__(self) -> str:
        from toolpace.machine.table import title

        return one_line(self, title(self))
