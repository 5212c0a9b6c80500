"""Which of LinuxCNC's kinematics a machine is, with the figures that its HAL pins want.

After "Five-axis kinematics" and "Switchable kinematics" of LinuxCNC's documents, and kins(9): a table C on a tilting
one, A or B (xyzac-trt-kins, xyzbc-trt-kins), a head B on C (5axiskins). Any machine runs as joints alone (trivkins).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from toolpace.common.errors import UsageError
from toolpace.common.units import MILLIMETRE
from toolpace.machine.machine import Machine

ALONG = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}
SAME = 1e-12
"""Figures of a machine file that are meant to be equal are [m]."""


@dataclass(frozen=True)
class Pattern:
    """A kinematics module: what HAL loads, and the pins that it is set with."""

    module: str
    letters: tuple[str, ...]
    """Axis letters of its joints, in their order."""
    pins: Mapping[str, float] = field(default_factory=dict)
    """Values by pin [mm]."""
    tool_pin: str = ""
    """What the length of the tool in force is given to."""
    holds_tip: bool = False
    """Whether M428 and M429 switch holding the tip on and off."""


def as_joints(machine: Machine) -> Pattern:
    """Words are joint positions, whatever the chain."""
    turning = [machine.joints[k] for k in machine.rotary]
    letters = tuple(sorted(machine.joints[k] for k in machine.linear)) + tuple(sorted(turning))
    if not set(letters) <= set("XYZABCUVW"):
        raise UsageError(f"machine {machine.name}: LinuxCNC has no axis for joints {', '.join(machine.joints)}")
    return Pattern(f"trivkins coordinates={''.join(letters)} kinstype=1", letters)


def holding_tip(machine: Machine) -> Pattern:
    """The kinematics under which words are the tip in the part, by M428. Raises UsageError where there is none."""
    chain = machine.file.chain
    if _tilting_table(machine, "A", "X") and chain.workpiece == ("A", "C"):
        return _table(machine, "xyzac-trt-kins", ("X", "Y", "Z", "A", "C"), "y-offset", 1)
    if _tilting_table(machine, "B", "Y") and chain.workpiece == ("B", "C"):
        return _table(machine, "xyzbc-trt-kins", ("X", "Y", "Z", "B", "C"), "x-offset", 0)
    if chain.tool == ("X", "Y", "Z", "C", "B") and _directed(machine, {"C": (0, 0, 1), "B": (0, -1, 0)}):
        return _head(machine)
    raise UsageError(f"machine {machine.name}: is none of LinuxCNC's xyzac-trt, xyzbc-trt, 5axiskins; run it as joints")


def _directed(machine: Machine, wanted: Mapping[str, tuple[int, int, int]]) -> bool:
    """Whether the linear joints run along their letters, and others as said."""
    joints = machine.file.joints
    every = {**ALONG, **wanted}
    return set(every) == set(joints) and all(np.allclose(joints[name].direction, way) for name, way in every.items())


def _tilting_table(machine: Machine, tilt: str, along: str) -> bool:
    """A table C on a tilting one, both turning the part by the right-hand rule."""
    return set(machine.file.chain.tool) == set("XYZ") and _directed(machine, {tilt: ALONG[along], "C": (0, 0, 1)})


def _table(machine: Machine, module: str, letters: tuple[str, ...], side: str, across: int) -> Pattern:
    """Part turned by C, then by a tilt whose axis is offset to one side, and upwards."""
    chain, joints = machine.file.chain, machine.file.joints
    _at_zero(machine, (*chain.spindle_nose[:2], chain.spindle_nose[2] - chain.tool_length, *chain.workpiece_origin))
    turned = np.array(joints["C"].point)
    offset = (np.array(joints[letters[3]].point) - turned) / MILLIMETRE
    # its directions are the right-hand rule's for the part unless `conventional-directions` is set
    pins = {
        "x-rot-point": turned[0] / MILLIMETRE, "y-rot-point": turned[1] / MILLIMETRE,
        side: offset[across], "z-offset": offset[2] + turned[2] / MILLIMETRE,
    }  # fmt: skip
    pins = {f"{module}.{name}": float(value) for name, value in pins.items()}
    return Pattern(f"{module} sparm=identityfirst", letters, pins, f"{module}.tool-offset", True)


def _head(machine: Machine) -> Pattern:
    """Both rotary axes meet above the tip; the distance is one pin, so that the tool's length is part of it."""
    chain, joints = machine.file.chain, machine.file.joints
    tip = np.array(chain.spindle_nose) - np.array([0.0, 0.0, chain.tool_length])
    _at_zero(machine, (*tip, *chain.workpiece_origin))
    pivots = [np.array(joints[name].point) for name in "CB"]
    _at_zero(machine, (*pivots[0][:2], *pivots[1][:2]))
    height = float(pivots[1][2] - tip[2]) / MILLIMETRE
    letters = ("X", "Y", "Z", "B", "C", "W")
    return Pattern(
        "5axiskins coordinates=XYZBCW sparm=identityfirst", letters, {"5axiskins.pivot-length": height}, holds_tip=True
    )


def _at_zero(machine: Machine, figures: tuple[float, ...]) -> None:
    if np.abs(figures).max() > SAME:
        raise UsageError(
            f"machine {machine.name}: LinuxCNC's kinematics have the tip in the part's origin where every joint is "
            "zero; mount the part there"
        )
