"""A five-axis machine: joint chains from the bed to the workpiece and to the tool, limits and travel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from toolpace.arrays import Bools, Floats, Ints
from toolpace.description import one_line
from toolpace.equality import ByValue
from toolpace.errors import MachineError, UsageError, did_you_mean
from toolpace.files.toml import toml_text
from toolpace.machine import kinematics
from toolpace.machine.continuation import rotary_between, turn_between
from toolpace.machine.file import FILE, MachineFile, read_machine
from toolpace.machine.geometry import Geometry, chain_geometry
from toolpace.machine.inverse import POLE_TOLERANCE, choose_rotary
from toolpace.machine.limits import Limits
from toolpace.machine.refusals import check_travel
from toolpace.machine.table import rows, title
from toolpace.machine.text import machine_text
from toolpace.toolpath import ToolPath

__all__ = ["Limits", "Machine"]

FOLDER = Path(__file__).parent / "builtin"


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
    """Joints, travel and chain as plain arrays: what the kinematics need."""

    def __post_init__(self) -> None:
        geometry = chain_geometry(self.file, self.source or self.file.name)
        values = list(self.file.joints.values())
        derived = {
            "name": geometry.name,
            "joints": geometry.joints,
            "kind": geometry.kind,
            "is_rotary": geometry.is_rotary,
            "rotary": geometry.rotary,
            "linear": geometry.linear,
            "limits": Limits(
                [joint.velocity for joint in values],
                [joint.acceleration for joint in values],
                [joint.jerk for joint in values],
                geometry.joints,
            ),
            "travel": geometry.travel,
            "wrap": geometry.wrap,
            "tool_length": self.file.chain.tool_length,
            "geometry": geometry,
        }
        for key, value in derived.items():
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
            with path.open(encoding="utf-8-sig") as stream:
                # It is read once (it may be a pipe), and no further than a machine file can go (it may never end).
                text = stream.read(FILE.longest + 1)
        except (OSError, ValueError) as error:
            if path.suffix == ".toml" or isinstance(error, ValueError) or _exists(path):
                reason = getattr(error, "strerror", None) or "not a text file (UTF-8)"
                raise MachineError(f"machine file {given}: {reason}; name a built-in machine or a .toml file") from None
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

    @property
    def setup(self) -> dict[str, Any]:
        """The set-up sheet in its file, as it stands there; empty where there is none. Reading makes sense of it."""
        return self.file.setup

    def to_toml(self) -> str:
        """The text of a machine file that loads to exactly this machine, each line explained.

        It is in those units in which its figures are shortest, mm and deg before others.
        """
        leanings = dict(zip(self.geometry.rotary_joints, self.geometry.leanings))
        setup = {"setup": self.file.setup} if self.file.setup else {}
        return machine_text(self.file, leanings) + ("\n" + toml_text(setup) if setup else "")

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

    def reserved(self, share: float) -> Machine:
        """The machine with a share of each limit kept back, for what is added to the motion later: see Follower."""
        if not 0.0 <= share < 1.0:
            raise UsageError(f"machine {self.name}: a reserve of {share:g}; give a share from 0 to below 1")
        return self.with_limits(self.limits.scaled(*(1.0 - share for _ in range(3))))

    def _with_chain(self, **changes: object) -> Machine:
        import msgspec

        given = {key: value for key, value in changes.items() if value is not None}
        chain = msgspec.structs.replace(self.file.chain, **given)
        return replace(self, file=msgspec.structs.replace(self.file, chain=chain))

    def forward(self, q: Floats) -> tuple[Floats, Floats]:
        """Joint positions (n, m) to tips (n, 3) [m] and unit tool axes (n, 3)."""
        return kinematics.forward(self.geometry, q)

    def axis_at(self, rotary: Floats) -> Floats:
        """Rotary positions (n, 2) [rad] to unit tool axes (n, 3)."""
        return kinematics.axis_at(self.geometry, rotary)

    def rotary_solutions(self, axis: Floats, pole_tolerance: float = kinematics.POLE) -> tuple[Floats, Bools]:
        """Tool axes (n, 3) to both rotary solutions (n, 2, 2) [point, solution, joint] and pole (n,).

        Angles lie in [-pi, pi]; nan where no angles, whatever the travel, give the axis. At the pole the
        first rotary joint is free; it is returned as zero there.
        """
        return kinematics.rotary_solutions(self.geometry, axis, pole_tolerance)

    def joints_at(self, tip: Floats, rotary: Floats) -> Floats:
        """Tips (n, 3) and rotary positions (n, 2) to joint positions (n, m), whatever their travel."""
        return kinematics.joints_at(self.geometry, tip, rotary)

    def linear_jets(self, tip: Floats, rotary: Floats) -> Floats:
        """Derivatives 0..3 of tip (4, n, 3) and rotary joints (4, n, 2) to those of all joints (4, n, m)."""
        return kinematics.linear_jets(self.geometry, tip, rotary)

    def rotary_jets(self, axis: Floats, rotary: Floats) -> Floats:
        """Derivatives 0..3 of the tool axis (4, n, 3) to those of the rotary joints (4, n, 2) near `rotary`.

        At the pole the first rotary joint keeps its given position and rests. nan where the axis cannot be
        reached, and in the derivatives where it lies on the edge of reach.
        """
        return kinematics.rotary_jets(self.geometry, axis, rotary)

    def axis_jets(self, rotary: Floats) -> Floats:
        """Derivatives 0..3 of the rotary joints (4, n, 2) to those of the tool axis (4, n, 3)."""
        return kinematics.axis_jets(self.geometry, rotary)

    def tip_lever(self, tip: Floats, rotary: Floats) -> Floats:
        """(n, 2) most motion of a linear joint per unit of each rotary joint while the tip stands [m/rad]."""
        return kinematics.tip_lever(self.geometry, tip, rotary)

    def choose_rotary(self, toolpath: ToolPath, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
        """Rotary positions (n, 2) [rad] along a tool path, unwound; see machine/inverse.py. Raises ReachError."""
        return choose_rotary(self.geometry, toolpath, pole_tolerance)

    def turn_between(self, axis: Floats, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
        """(n - 1,) most turn of a rotary joint from one tool axis (n, 3) to the next on either solution [rad]."""
        return turn_between(self.geometry, axis, pole_tolerance)

    def rotary_between(
        self, toolpath: ToolPath, known: Ints, rotary: Floats, pole_tolerance: float = POLE_TOLERANCE
    ) -> Floats:
        """Rotary positions (n, 2) [rad] along a tool path with points put in, on the branch chosen without them.

        Those at its points `known` (k,) are `rotary` (k, 2); see machine/continuation.py. Raises ReachError.
        """
        return rotary_between(self.geometry, toolpath, known, rotary, pole_tolerance)

    def check_travel(self, q: Floats, block: Ints, source: str = "") -> None:
        """Raise ReachError where joint positions (n, m) leave the travel.

        `block` (n,) are line numbers, and `source` the program that they are of, for the message.
        """
        check_travel(self.geometry, q, block, source)

    def summary(self) -> list[dict[str, str]]:
        """One row a joint, in mm and deg: machine, class, joint, kind, carries, travel, limits."""
        return rows(self.file, self.kind)

    def __repr__(self) -> str:
        return one_line(self, title(self.file, self.kind))


def _exists(path: Path) -> bool:
    """Whether something has the name, also one that is too long for anything to have."""
    try:
        return path.exists()
    except OSError:
        return False


def check_machine(machine: object, asks: str, wanted: str = "a Machine") -> None:
    """Raise UsageError where something else is given in place of a machine; `asks` is who asks for it."""
    if isinstance(machine, Machine):
        return
    if isinstance(machine, str):
        raise UsageError(f"{asks}: '{machine}' is the name of a machine; give Machine.load('{machine}')")
    raise UsageError(f"{asks}: {type(machine).__name__} in place of a machine; give {wanted}")
