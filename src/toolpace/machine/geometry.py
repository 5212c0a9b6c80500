"""The kinematic geometry of a machine as plain arrays, from its file; and the diagnosis of errors in its chain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import MachineError, did_you_mean
from toolpace.common.files.toml import toml_value
from toolpace.machine.file import MachineFile
from toolpace.machine.plausibility import check_chain

PARALLEL = 1e-6
"""Sine below which two directions count as parallel."""
SHOWN = math.radians(30.0)
"""The turn that is shown: small enough for most travels, large enough to be seen [rad]."""
STILL = 1e-6
"""How little the tool axis moves where it is said to stay."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """Joints, travel and chain of a machine: all that its kinematics need. The arrays are read-only.

    The chain is seen from the workpiece, see kernels/kinematics/chain.py.
    """

    name: str
    """Of the machine, for messages."""
    joints: tuple[str, ...]
    """(m,) names, in the order of the file; columns of joint arrays."""
    kind: str
    """"table-table", "head-table" or "head-head"."""
    is_rotary: Bools
    """(m,)"""
    travel: Floats
    """(m, 2) lowest and highest position [m or rad]; infinite where the joint wraps."""
    wrap: Bools
    """(m,) whether the joint turns without end."""
    frame: Floats
    """(9, 3) u1, u2, a0, c0, c1, c2 and the linear directions."""
    group: Ints
    """(3,) how many rotary joints lie between the workpiece and each linear joint."""
    place: Ints
    """(5,) columns of the two rotary joints, then of the linear ones."""

    def __post_init__(self) -> None:
        for array in (self.is_rotary, self.travel, self.wrap, self.frame, self.group, self.place):
            array.flags.writeable = False

    @property
    def rotary(self) -> Ints:
        """(2,) columns of the rotary joints, nearest the workpiece first; rotary arrays are in this order."""
        return self.place[:2]

    @property
    def rotary_joints(self) -> tuple[str, str]:
        """Names of the rotary joints, nearest the workpiece first."""
        first, second = self.rotary
        return self.joints[first], self.joints[second]

    @property
    def linear(self) -> Ints:
        """(3,) columns of the linear joints."""
        return self.place[2:]

    @property
    def leanings(self) -> tuple[str, str]:
        """What 30 degrees of each rotary joint do to the tool axis, in words; nearest the workpiece first."""
        return leaning(self.rotary_joints, self.frame, 0), leaning(self.rotary_joints, self.frame, 1)


def chain_geometry(file: MachineFile, source: str) -> Geometry:
    """The geometry of a machine; `source` names its file in messages. Raises MachineError."""
    chain, joints, names = file.chain, file.joints, list(file.joints)
    _check_names(file, source)
    check_chain(chain, source)
    order = [(name, -1) for name in reversed(chain.workpiece)] + [(name, 1) for name in chain.tool]
    rotary = [(name, sign) for name, sign in order if joints[name].kind == "rotary"]
    linear = [name for name in names if joints[name].kind == "linear"]
    if len(rotary) != 2 or len(linear) != 3:
        raise MachineError(
            f"{source}: {len(linear)} linear and {len(rotary)} rotary joints; five axes need exactly "
            "three linear and two rotary ones"
        )
    directions = {name: np.array(joint.direction) / math.hypot(*joint.direction) for name, joint in joints.items()}
    signs = dict(order)
    first, second = rotary[0][0], rotary[1][0]
    u1, u2 = (sign * directions[name] for name, sign in rotary)
    a0 = _unit(chain.tool_axis, "tool_axis", source)
    orientation = workpiece_orientation(file, source)
    check_rotary(file, (first, second), np.array([u1, u2, a0]) @ orientation, source)
    p1, p2 = np.array(joints[first].point), np.array(joints[second].point)
    tip0 = np.array(chain.spindle_nose) - chain.tool_length * a0
    rows = [u1, u2, a0, np.array(chain.workpiece_origin) - p1, p2 - p1, tip0 - p2]
    rows += [signs[name] * directions[name] for name in linear]
    frame = np.ascontiguousarray(np.array(rows) @ orientation)
    position = {name: i for i, (name, _) in enumerate(order)}
    group = np.array([sum(position[name] > position[turn] for turn, _ in rotary) for name in linear], dtype=np.int64)
    place = np.array([names.index(name) for name in (first, second, *linear)], dtype=np.int64)
    if not _spans_space(frame, group):
        raise lie_in_a_plane(file, linear, directions, source)
    on_table = sum(sign < 0 for _, sign in rotary)
    values = joints.values()
    return Geometry(
        name=file.name,
        joints=tuple(names),
        kind={2: "table-table", 1: "head-table", 0: "head-head"}[on_table],
        is_rotary=np.array([joint.kind == "rotary" for joint in values]),
        travel=np.array([joint.travel or (-math.inf, math.inf) for joint in values]),
        wrap=np.array([joint.wrap for joint in values]),
        frame=frame,
        group=group,
        place=place,
    )


def _check_names(file: MachineFile, source: str) -> None:
    used: set[str] = set()
    for side in ("workpiece", "tool"):
        for name in getattr(file.chain, side):
            if name not in file.joints:
                raise MachineError(
                    f"{source}: [chain] {side} names joint '{name}', which has no table [joints.{name}]; "
                    f"{did_you_mean(name, file.joints)}"
                )
            if name in used:
                raise MachineError(f"{source}: joint {name} appears twice in [chain]; every joint moves one side once")
            used.add(name)
    for name in file.joints:
        if name not in used:
            raise MachineError(f"{source}: joint {name} is in neither [chain] workpiece nor tool; add it to one")


def _unit(vector: tuple[float, float, float], key: str, source: str) -> Floats:
    length = math.hypot(*vector)
    if not length > 1e-9:
        raise MachineError(f"{source}: [chain] {key} = {list(vector)} is no direction; give e.g. [0, 0, 1]")
    return np.array(vector) / length


def workpiece_orientation(file: MachineFile, source: str) -> Floats:
    """(3, 3) columns x, y, z of the workpiece frame in the bed frame."""
    x = _unit(file.chain.workpiece_x, "workpiece_x", source)
    z = _unit(file.chain.workpiece_z, "workpiece_z", source)
    if abs(float(x @ z)) > 1e-6:
        raise MachineError(
            f"{source}: [chain] workpiece_x and workpiece_z are not at a right angle; give both directions"
        )
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _spans_space(frame: Floats, group: Ints) -> bool:
    """Whether the linear joints move in all directions at some angles of the rotary joints."""
    for t1 in np.arange(0.1, 6.2, 0.7):
        for t2 in np.arange(0.1, 6.2, 0.7):
            columns = [
                turned(frame[0], t1 if g > 0 else 0.0, turned(frame[1], t2 if g > 1 else 0.0, direction))
                for g, direction in zip(group, frame[6:])
            ]
            if abs(float(np.linalg.det(np.array(columns)))) > PARALLEL:
                return True
    return False


def parallel(u: Floats, v: Floats) -> bool:
    """Whether two unit vectors (3,) lie along one line."""
    return bool(np.linalg.norm(np.cross(u, v)) < PARALLEL)


def check_rotary(file: MachineFile, rotary: tuple[str, str], frame: Floats, source: str) -> None:
    """Refuse rotary joints that cannot tilt the tool in all directions.

    `rotary` are the names of both, nearest the workpiece first; `frame` (3, 3) is u1, u2, a0 in the workpiece frame.
    """
    first, second = rotary
    if parallel(frame[0], frame[1]):
        raise MachineError(
            f"{source}: rotary joints {first} and {second} are parallel; the tool could tilt one way only; correct one "
            f"of their directions {_directions(file, rotary)}"
        )
    if parallel(frame[1], frame[2]):
        raise MachineError(
            f"{source}: rotary joint {second} turns about the tool axis and cannot tilt it: {_order(file, rotary)} "
            f"As it stands {leaning(rotary, frame, 0)}, and {leaning(rotary, frame, 1)}"
        )


def _order(file: MachineFile, rotary: tuple[str, str]) -> str:
    """The order that was most likely meant: what turns about the tool axis comes before what tilts it."""
    first, second = rotary
    for side, order in (("workpiece", file.chain.workpiece), ("tool", file.chain.tool)):
        if first in order and second in order:
            # Linear joints that come last tell of a list that begins at its other end.
            other = {first: second, second: first}
            backwards = file.joints[order[0]].kind == "rotary" and file.joints[order[-1]].kind == "linear"
            meant = order[::-1] if backwards else tuple(other.get(name, name) for name in order)
            return (
                f"[chain] {side} goes from the bed to the {side}, and is {toml_value(list(order))};"
                f" should it be {toml_value(list(meant))}?"
            )
    return f"should {second} be in [chain] workpiece, and {first} in tool?"


def _directions(file: MachineFile, names: tuple[str, str]) -> str:
    directions = ([f"{figure:g}" for figure in file.joints[name].direction] for name in names)
    return " and ".join(f"[{', '.join(figures)}]" for figures in directions)


def lie_in_a_plane(file: MachineFile, names: list[str], directions: dict[str, Floats], source: str) -> MachineError:
    """The error for linear joints that do not span space; those that move along one line are named."""
    pairs = ((one, other) for k, one in enumerate(names) for other in names[k + 1 :])
    alike = next((pair for pair in pairs if parallel(directions[pair[0]], directions[pair[1]])), None)
    why = ""
    if alike is not None:
        shown = _directions(file, alike)
        why = f"; {alike[0]} and {alike[1]} move along one line, directions {shown}: correct one of them"
    return MachineError(
        f"{source}: the directions of the linear joints {', '.join(names)} lie in one plane; they must span space{why}"
    )


def turned(u: Floats, angle: float, v: Floats) -> Floats:
    """The vector v (3,) turned by an angle [rad] about the unit vector u (3,) (Rodrigues' formula)."""
    out: Floats = math.cos(angle) * v + math.sin(angle) * np.cross(u, v) + (1.0 - math.cos(angle)) * (u @ v) * u
    return out


def tool_axis(frame: Floats, first: float, second: float) -> Floats:
    """The tool axis (3,) in the workpiece frame at angles [rad] of both rotary joints; `frame` begins u1, u2, a0."""
    return turned(frame[0], first, turned(frame[1], second, frame[2]))


def leaning(names: tuple[str, str], frame: Floats, joint: int) -> str:
    """Where 30 degrees of rotary joint 0 or 1 take the tool axis, in words, seen from the workpiece.

    `names` are of both rotary joints, nearest the workpiece first; `frame` begins u1, u2, a0. A joint that turns about
    the tool axis shows what it does once the other one has tilted it.
    """
    turn, other = f"{names[joint]} +30 deg", names[1 - joint]
    after = tool_axis(frame, *(SHOWN * (k == joint) for k in range(2)))
    if np.linalg.norm(after - frame[2]) > STILL:
        return f"{turn} leans the tool axis to {shown(after)}"
    before, after = tool_axis(frame, SHOWN * joint, SHOWN * (1 - joint)), tool_axis(frame, SHOWN, SHOWN)
    if np.linalg.norm(after - before) > STILL:
        return f"{turn} turns the tool axis that {other} +30 leans to {shown(before)} on to {shown(after)}"
    return f"{turn} leaves the tool axis where it is"


def shown(vector: Floats) -> str:
    """A direction in three decimals at most."""
    return "(" + ", ".join(f"{figure:.3f}".rstrip("0").rstrip(".") for figure in np.round(vector, 3) + 0.0) + ")"
