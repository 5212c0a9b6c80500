"""Archives of a Sinumerik in ASCII, written for a machine from what the manuals say of each datum.

Commissioning Manual Operate IM9, "Swiveling": a head is measured from the tool adapter to the second axis (I3), from
there to the first (I2); a table from machine zero to the first axis (I2), from there to the second (I3); the last one
closes the chain. The direction of an axis is that about which it turns what it carries.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.units import DEGREE, INCH, MILLIMETRE
from toolpace.machine.machine import Machine

GENERIC = {"T": 24, "P": 40, "M": 56}
BY_LETTERS = {
    "T": {"AB": 16, "BA": 18, "CA": 20, "CB": 21},
    "P": {"AB": 32, "AC": 33, "BA": 34, "BC": 35},
    "M": {"AB": 48, "AC": 49, "BA": 50, "BC": 51},
}
"""Transformation types (Function Manual Transformations, F2, page 148)."""
MACHINE_AXES = (4, 2, 6, 1, 3)
"""Machine axes of X, Y, Z and of both turning axes: the channel's order is not that of the machine."""
TURN = 2.0 * math.pi


@dataclass
class Archive:
    """A machine as its control knows it."""

    machine: Machine
    unit: str = "mm"
    slide: Sequence[float] = (0.0, 0.0)
    """By how much the points on both turning axes are moved along them [m]."""
    zero: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """(3,) machine zero in the frame of the machine file [m]; set by what is written."""

    @property
    def kind(self) -> str:
        return {"head-head": "T", "table-table": "P", "head-table": "M"}[self.machine.kind]

    @property
    def turning(self) -> list[str]:
        """The first and the second turning axis: from the bed on, that in the head first."""
        joints, chain = self.machine.file.joints, self.machine.file.chain
        return [name for side in (chain.tool, chain.workpiece) for name in side if joints[name].kind == "rotary"]

    def direction(self, place: int) -> np.ndarray:
        return np.array(self.machine.file.joints[self.turning[place]].direction, dtype=float)

    def point(self, place: int) -> np.ndarray:
        along = self.direction(place)
        point = np.array(self.machine.file.joints[self.turning[place]].point)
        return point + self.slide[place] * along / np.linalg.norm(along)

    def vectors(self) -> dict[str, np.ndarray]:
        """The closed chain [m]; machine zero is where the nose is."""
        nose, first, second = np.array(self.machine.file.chain.spindle_nose), self.point(0), self.point(1)
        self.zero = nose
        if self.kind == "T":
            return {"I1": nose - first, "I2": first - second, "I3": second - nose}
        if self.kind == "P":
            return {"I2": first - nose, "I3": second - first, "I4": nose - second}
        return {"I1": nose - first, "I2": first - nose, "I3": second - nose, "I4": nose - second}

    def transformation(self, number: int, count: int, typed: int) -> list[str]:
        """Lines of a transformation, generic or by letters."""
        vectors, old = self.vectors(), typed % 16 < 8
        names = {
            "T": {"PART_OFFSET": "I1", "JOINT_OFFSET": "I2", "BASE_TOOL": "I3"},
            "P": {"BASE_TOOL": "I2", "JOINT_OFFSET": "I3", "PART_OFFSET": "I4"},
            "M": {"JOINT_OFFSET": "I1", "BASE_TOOL": "I2", "JOINT_OFFSET_PART": "I3", "PART_OFFSET": "I4"},
        }[self.kind]
        if old and self.kind == "M":
            # older types have no vector beside that of the adapter in the head: machine zero is where its axis is
            self.zero = self.point(0)
            vectors["I3"], vectors["I4"] = self.point(1) - self.point(0), self.point(0) - self.point(1)
            names = {"JOINT_OFFSET": "I3", "BASE_TOOL": "I2", "PART_OFFSET": "I4"}
        lines = [f"N24100 $MC_TRAFO_TYPE_{number}={typed}"]
        lines += [f"N24110 $MC_TRAFO_AXES_IN_{number}[{k}]={k + 1}" for k in range(5)]
        for name, vector in names.items():
            lines += self._components(f"$MC_TRAFO5_{name}_{count}", vectors[vector])
        for place in (0, 1):
            direction = self.direction(place)
            plus = not old or direction.sum() > 0
            lines.append(f"N24520 $MC_TRAFO5_ROT_SIGN_IS_PLUS_{count}[{place}]={'TRUE' if plus else 'FALSE'}")
            if not old:
                lines += [f"$MC_TRAFO5_AXIS{place + 1}_{count}[{k}]={float(direction[k])!r}" for k in range(3)]
        return lines

    def letters(self) -> str:
        """What both axes turn about, as the older types have it; empty for inclined axes."""
        words = ""
        for place in (0, 1):
            along = np.abs(self.direction(place))
            words += "ABC"[int(along.argmax())] if np.count_nonzero(along) == 1 else "?"
        return "" if "?" in words or list(words) != self.turning else words

    def carrier(self, number: int) -> list[str]:
        """Lines of a swivel data set."""
        vectors = self.vectors()
        lines = []
        for first, values, scale in (
            (1, vectors.get("I1", np.zeros(3)), self.length), (4, vectors.get("I2", np.zeros(3)), self.length),
            (7, self.direction(0), 1.0), (10, self.direction(1), 1.0),
            (15, vectors.get("I3", np.zeros(3)), self.length), (18, vectors.get("I4", np.zeros(3)), self.length),
        ):  # fmt: skip
            lines += [f"$TC_CARR{first + k}[{number}]={float(values[k]) / scale!r}" for k in range(3)]
        lines += [f"$TC_CARR{21 + place}[{number}]=({name})" for place, name in enumerate(self.turning)]
        return [*lines, f'$TC_CARR23[{number}]="{self.kind}"']

    def elements(self, world: np.ndarray) -> list[str]:
        """Lines of a kinematic chain from a point `world` (3,) [m], and of its transformation.

        The workpiece's side is parallel to the first element of the tool's, and elements are numbered backwards.
        """
        joints, chain = self.machine.file.joints, self.machine.file.chain
        nose, at = np.array(chain.spindle_nose), {1.0: world, -1.0: world}
        table = np.array([1.0, 2.0, 3.0])
        self.zero = {"P": nose, "M": world, "T": world + table * self.length}[self.kind]
        sides: dict[float, list[tuple[str, str, np.ndarray]]] = {1.0: [], -1.0: []}
        for sense, names in ((1.0, chain.tool), (-1.0, chain.workpiece)):
            for name in names:
                if joints[name].kind == "rotary":
                    point = self.point(self.turning.index(name))
                    sides[sense] += [
                        ("OFFSET", "", (point - at[sense]) / self.length),
                        ("AXIS_ROT", name, 1.7 * self.direction(self.turning.index(name))),
                    ]
                    at[sense] = point
                else:
                    sides[sense].append(("AXIS_LIN", name, sense * 2.0 * np.eye(3)["XYZ".index(name)]))
        sides[1.0].append(("OFFSET", "", (nose - at[1.0]) / self.length))
        sides[-1.0].append(("OFFSET", "", table))
        names = [f"T {k}" for k in range(len(sides[1.0]))], [f"P {k}" for k in range(len(sides[-1.0]))]
        lines: list[str] = []
        first = len(names[0]) + len(names[1])
        for elements, own in zip(sides.values(), names):
            for k, (kind, axis, vector) in enumerate(elements):
                first -= 1
                lines += [f'$NK_NAME[{first}]="{own[k]}" \'38c0', f'$NK_TYPE[{first}]="{kind}"']
                lines += [f"$NK_OFF_DIR[{first},{i}]={float(vector[i])!r}" for i in range(3)]
                lines.append(f'$NK_NEXT[{first}]="{own[k + 1] if k + 1 < len(own) else ""}"')
                if axis:
                    place = ["X", "Y", "Z", *self.turning].index(axis)
                    lines.append(f'$NK_AXIS[{first}]="M{axis}{MACHINE_AXES[place]}"')
                if own[k] == "T 0":
                    lines.append(f'$NK_PARALLEL[{first}]="P 0"')
        ends = f'$NT_T_CHAIN_LAST_ELEM[1]="{names[0][-1]}"', f'$NT_P_CHAIN_LAST_ELEM[1]="{names[1][-1]}"'
        return [*lines, '$NT_TRAFO_TYPE[1]="TRAORI_DYN"', *ends]

    @property
    def length(self) -> float:
        return {"mm": MILLIMETRE, "in": INCH}[self.unit]

    def _components(self, name: str, vector: np.ndarray) -> list[str]:
        return [f"{name}[{k}]={float(vector[k]) / self.length!r}" for k in range(3)]

    def axes(self) -> list[str]:
        """Lines of general, channel and axis data."""
        names = ["X", "Y", "Z", *self.turning]
        lines = [f"N10240 $MN_SCALING_SYSTEM_IS_METRIC={int(self.unit == 'mm')}"]
        lines += [f'N10000 $MN_AXCONF_MACHAX_NAME_TAB[{k - 1}]="M{name}{k}"' for name, k in zip(names, MACHINE_AXES)]
        lines.append("CHANDATA(1)")
        lines += [f"N20050 $MC_AXCONF_GEOAX_ASSIGN_TAB[{k}]={k + 1}" for k in range(3)]
        for k, (name, machine_axis) in enumerate(zip(names, MACHINE_AXES)):
            lines.append(f"N20070 $MC_AXCONF_MACHAX_USED[{k}]={machine_axis}")
            lines.append(f'N20080 $MC_AXCONF_CHANAX_NAME_TAB[{k}]="{name}"')
        for name, machine_axis in zip(names, MACHINE_AXES):
            lines += self._axis(name, f"AX{machine_axis}")
        return lines

    def _axis(self, name: str, word: str) -> list[str]:
        joint = self.machine.file.joints[name]
        rotary = joint.kind == "rotary"
        acceleration = TURN if rotary else self.length if self.unit == "in" else 1.0
        lines = [
            f"N30300 $MA_IS_ROT_AX[{word}]={int(rotary)}",
            f"N30310 $MA_ROT_IS_MODULO[{word}]={int(joint.wrap)}",
            f"N32000 $MA_MAX_AX_VELO[{word}]={joint.velocity * 60.0 / (TURN if rotary else self.length)!r}",
            f"N32300 $MA_MAX_AX_ACCEL[0,{word}]={joint.acceleration / acceleration!r} ; DYNNORM",
            f"N32431 $MA_MAX_AX_JERK[0,{word}]={joint.jerk / acceleration!r}",
        ]
        if joint.travel is not None:
            low, high = (end / (DEGREE if rotary else self.length) for end in joint.travel)
            lines += [f"N36100 $MA_POS_LIMIT_MINUS[{word}]={low!r}", f"N36110 $MA_POS_LIMIT_PLUS[{word}]={high!r}"]
        return lines


def changed(lines: Sequence[str], values: Mapping[str, str | None]) -> list[str]:
    """Lines with other values by the name of the datum with its index; None takes a line out, new ones are added."""
    left = dict(values)
    found = []
    for line in lines:
        name = line.partition("=")[0].split(" ")[-1]
        if name not in values:
            found.append(line)
        elif (value := left.pop(name, values[name])) is not None:
            found.append(f"{line.partition('=')[0]}={value}")
    return found + [f"{name}={value}" for name, value in left.items() if value is not None]
