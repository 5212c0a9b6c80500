"""Five-axis machines: joint chains to the workpiece and to the tool, limits and travel."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, Floats, Ints, integers, number, numbers
from toolpace.common.errors import MachineError, UsageError, did_you_mean
from toolpace.common.files.toml import toml_text
from toolpace.common.units import FARTHEST_PART, LONGEST_TOOL, METRES, refuse_other_unit
from toolpace.common.value_objects import ByValue, one_line
from toolpace.machine.dynamics import Dynamics
from toolpace.machine.dynamics.torques import machine_torques
from toolpace.machine.file import FILE, MachineFile, WorkpieceFile, read_machine
from toolpace.machine.file_writer import machine_text, rows, title
from toolpace.machine.geometry import Geometry, chain_geometry
from toolpace.machine.inverse import POLE_TOLERANCE, choose_rotary, rotary_between, turn_between
from toolpace.machine.kinematics import Posed
from toolpace.machine.limits import KINDS, Limits
from toolpace.machine.plausibility import ask_about, check_chain, check_mass, is_usual
from toolpace.machine.unreachable import check_travel
from toolpace.programs.toolpath import ToolPath

__all__ = ["Limits", "Machine"]

FOLDER = Path(__file__).parent / "builtin"


@dataclass(frozen=True, eq=False, repr=False)
class Machine(ByValue, Posed):
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
                machine_torques(self.file, self.source or self.file.name),
                curves=[curve for joint in values for curve in joint.curves],
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
        which = str(name_or_path)
        built_in = FOLDER / f"{which}.toml"
        path = built_in if which in cls.names() else Path(which)
        try:
            with path.open(encoding="utf-8-sig") as stream:
                # It is read once (it may be a pipe), and no further than a machine file can go (it may never end).
                text = stream.read(FILE.longest + 1)
        except (OSError, ValueError) as error:
            if path.suffix == ".toml" or isinstance(error, ValueError) or _exists(path):
                reason = getattr(error, "strerror", None) or "not a text file (UTF-8)"
                raise MachineError(f"machine file {which}: {reason}; name a built-in machine or a .toml file") from None
            names = ", ".join(cls.names())
            close = did_you_mean(which, cls.names())
            hint = f"{close} " if close.startswith("did") else ""
            raise MachineError(
                f"unknown machine '{which}'; {hint}built-in: {names}; or give the path of a .toml file"
            ) from None
        return _built_in(text, which) if path == built_in and cls is Machine else cls.from_toml(text, which)

    @classmethod
    def from_toml(cls, text: str, source: str = "machine file") -> Machine:
        """A machine from the text of a file; `source` names it in messages. Raises MachineError.

        UnitWarning where a limit is not one of a machine tool, with the unit that was likely meant: see the tutorial.
        """
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
        frame = {"origin": origin, "x": x, "z": z}
        vectors = {
            f"workpiece_{name}": tuple(numbers(value, f"machine {self.name}: mounted: {name}", (3,)).tolist())
            for name, value in frame.items()
            if value is not None
        }
        for each in vectors.get("workpiece_origin", ()):
            refuse_other_unit(each, FARTHEST_PART, f"machine {self.name}: mounted: origin", METRES)
        return self._with_chain(**vectors)

    @property
    def dynamics(self) -> Dynamics:
        """Torques and forces of the joints at a motion, from the masses in its file; all zero where it has none."""
        return Dynamics.of_machine(self.file)

    def with_workpiece(
        self, mass: float, centre: Sequence[float], inertia: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> Machine:
        """The machine with another part [kg] on its table, fixture and all, in place of that of its file.

        `centre` [m] is that of its mass, in the frame of the bed with every joint at zero, `inertia` [kg m^2] about it:
        xx, yy, zz, and xy, xz, yz where they are not zero. It counts where motors have limits of torque or force.
        Raises MachineError.
        """
        import msgspec

        place = f"machine {self.name}: with_workpiece"
        middle = numbers(centre, f"{place}: centre", (3,), unit="m").tolist()
        figures = numbers(inertia, f"{place}: inertia", ("k",), unit="kg m^2").tolist()
        part = WorkpieceFile(number(mass, f"{place}: mass"), tuple(middle), tuple(figures))
        check_mass(part, place)
        return replace(self, file=msgspec.structs.replace(self.file, workpiece=part))

    def with_tool(self, length: float) -> Machine:
        """The machine with a tool of another length [m]; itself where the length is nan, or that of its own."""
        length = float(numbers(length, f"machine {self.name}: tool length", (), finite=False, unit="m"))
        refuse_other_unit(length, LONGEST_TOOL, f"machine {self.name}: tool length", METRES)
        return self if math.isnan(length) or length == self.tool_length else self._with_chain(tool_length=length)

    def with_tools(self, lengths: Iterable[float]) -> list[Machine]:
        """The machine with a tool of each of these lengths [m], as `with_tool`; equal ones are one object."""
        values = list(lengths) if isinstance(lengths, Iterator) else lengths
        figures = numbers(values, f"machine {self.name}: tool lengths", ("n",), finite=False, unit="m").tolist()
        cache: dict[float, Machine] = {}
        return [cache.setdefault(each, cache.get(each) or self.with_tool(each)) for each in figures]

    def with_limits(self, limits: Limits) -> Machine:
        """The machine with other limits; `limits` has its joints in the same order."""
        if not isinstance(limits, Limits):
            raise UsageError(f"machine {self.name}: {type(limits).__name__} in place of limits; give tp.Limits(...)")
        if len(limits) != len(self.joints):
            raise UsageError(f"limits of {len(limits)} joints given, machine {self.name} has {len(self.joints)}")
        import msgspec

        limits = limits.constants
        values = zip(self.file.joints.items(), limits.joints, limits.velocity, limits.acceleration, limits.jerk)
        joints = {
            name: msgspec.structs.replace(
                joint, velocity=float(v), acceleration=float(a), jerk=float(j),
                curves=tuple(replace(curve, joint=name) for curve in limits.curves if curve.joint == named),
            )
            for (name, joint), named, v, a, j in values
        }  # fmt: skip
        for name, joint in joints.items():
            before = self.file.joints[name]
            if all(is_usual(joint.kind, kind, getattr(before, kind)) for kind in KINDS):
                unit = "rad" if joint.kind == "rotary" else "m"
                ask_about(joint, f"machine {self.name}: with_limits: joint {name}", unit, 1.0)
        return replace(self, file=msgspec.structs.replace(self.file, joints=joints))

    def reserved(self, share: float) -> Machine:
        """The machine with a share of each limit kept back, for what is added to the motion later: see Follower."""
        if not 0.0 <= number(share, f"machine {self.name}: reserve") < 1.0:
            raise UsageError(f"machine {self.name}: a reserve of {share:g}; give a share from 0 to below 1")
        return self.with_limits(self.limits.scaled(*(1.0 - share for _ in range(3))))

    def _with_chain(self, **changes: object) -> Machine:
        import msgspec

        chain = msgspec.structs.replace(self.file.chain, **changes)
        check_chain(chain, f"machine {self.name}")
        return replace(self, file=msgspec.structs.replace(self.file, chain=chain))

    def choose_rotary(self, toolpath: ToolPath, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
        """Rotary positions (n, 2) [rad] along a tool path, unwound; see machine/inverse.py. Raises ReachError."""
        return choose_rotary(self.geometry, toolpath.with_tool(self.tool_length), pole_tolerance)

    def turn_between(self, axis: npt.ArrayLike, pole_tolerance: float = POLE_TOLERANCE) -> Floats:
        """(n - 1,) most turn of a rotary joint from one tool axis (n, 3) to the next on either solution [rad]."""
        return turn_between(self.geometry, self._axes(axis), pole_tolerance)

    def rotary_between(
        self,
        toolpath: ToolPath,
        known: npt.ArrayLike,
        rotary: npt.ArrayLike,
        pole_tolerance: float = POLE_TOLERANCE,
    ) -> Floats:
        """Rotary positions (n, 2) [rad] along a tool path with points put in, on the branch chosen without them.

        Those at its points `known` (k,) are `rotary` (k, 2); see machine/inverse.py. Raises ReachError.
        """
        at = integers(known, f"machine {self.name}: known", ("k",))
        last = len(toolpath) - 1
        if not len(at) or at[0] != 0 or at[-1] != last or (np.diff(at) <= 0).any():
            raise UsageError(
                f"machine {self.name}: known must ascend from 0, the first point, to {last}, the last of the tool path"
            )
        chosen = numbers(rotary, f"machine {self.name}: rotary", (len(at), 2), unit="rad")
        return rotary_between(self.geometry, toolpath.with_tool(self.tool_length), at, chosen, pole_tolerance)

    def check_travel(self, q: npt.ArrayLike, block: npt.ArrayLike, source: str = "") -> None:
        """Raise ReachError where joint positions (n, m) leave the travel, or are not finite.

        `block` (n,) are line numbers, and `source` the program that they are of, for the message.
        """
        poses = numbers(q, f"machine {self.name}: q", ("n", len(self.joints)), (len(self.joints),), finite=False)
        poses = poses if poses.ndim == 2 else poses[None]
        lines = np.atleast_1d(
            integers(block, f"machine {self.name}: block", (len(poses),), *([()] if len(poses) == 1 else []))
        )
        check_travel(self.geometry, poses, lines, source)

    def summary(self) -> list[dict[str, str]]:
        """One row a joint, in mm and deg: machine, class, joint, kind, carries, travel, limits."""
        return rows(self.file, self.kind)

    def __repr__(self) -> str:
        return one_line(self, title(self.file, self.kind))


@functools.cache
def _built_in(text: str, name: str) -> Machine:
    """A built-in machine, which is frozen, made once of the text of its file: that takes longer than many a program."""
    return Machine.from_toml(text, name)


def _exists(path: Path) -> bool:
    """Whether something has the name, also one that is too long for anything to have."""
    try:
        return path.exists()
    except OSError:
        return False


def check_machine(machine: object, caller: str, wanted: str = "a Machine") -> None:
    """Raise UsageError where something else is given in place of a machine; `caller` names who asks for it."""
    if isinstance(machine, Machine):
        return
    if isinstance(machine, str):
        raise UsageError(f"{caller}: '{machine}' is the name of a machine; give Machine.load('{machine}')")
    raise UsageError(f"{caller}: {type(machine).__name__} in place of a machine; give {wanted}")
