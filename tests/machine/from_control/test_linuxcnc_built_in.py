"""Built-in machines, written as LinuxCNC would have them and with the answers of one who knows them, are read back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.linuxcnc_files import ini_text, written
from tests.support.read_back import assert_comes_back, sense
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine.from_control import read_control
from toolpace.machine.from_control.stand_ins import Answers
from toolpace.machine.machine import Machine

ALONG = dict(zip("XYZABC", np.vstack([np.eye(3), np.eye(3)])))


def _can_be_told(machine: Machine) -> bool:
    """Whether each joint moves along or about its letter's axis, and turning joints come last on either side.

    LinuxCNC has no name for inclined axes, and its X, Y, Z move along the bed's.
    """
    joints, chain = machine.file.joints, machine.file.chain
    straight = all(
        name in ALONG and np.abs(np.cross(ALONG[name], joint.direction)).max() == 0.0 for name, joint in joints.items()
    )
    kinds = [[joints[name].kind for name in side] for side in (chain.workpiece, chain.tool)]
    return straight and all(side == sorted(side) for side in kinds)


MACHINES = [name for name in Machine.names() if _can_be_told(Machine.load(name))]


def _sections(machine: Machine) -> dict[str, dict[str, object]]:
    """Limits of axes and joints [mm, deg]."""
    sections: dict[str, dict[str, object]] = {}
    for number, (name, joint) in enumerate(machine.file.joints.items()):
        unit = DEGREE if joint.kind == "rotary" else MILLIMETRE
        low, high = joint.travel or (None, None)
        values = {
            "MIN_LIMIT": None if low is None else repr(low / unit),
            "MAX_LIMIT": None if high is None else repr(high / unit),
            "MAX_VELOCITY": repr(joint.velocity / unit),
            "MAX_ACCELERATION": repr(joint.acceleration / unit),
            "MAX_JERK": repr(joint.jerk / unit),
        }
        sections |= {f"AXIS_{name}": values, f"JOINT_{number}": values}
    return sections


def _answer(machine: Machine, question) -> str:
    """What one who knows the machine says: LinuxCNC's zero is where the nose is with every joint at zero."""
    chain, joints = machine.file.chain, machine.file.joints
    turning = {name for name, joint in joints.items() if joint.kind == "rotary"}
    if "slash" in question.what:
        return "/".join("".join(name for name in side if name in turning) for side in (chain.workpiece, chain.tool))
    if question.what.startswith("a point"):
        letter = question.what.split(" of ")[1][0]
        return ", ".join(repr((p - n) / MILLIMETRE) for p, n in zip(joints[letter].point, chain.spindle_nose))
    letter = question.what.removeprefix("positive ")[0]
    turns_tool = math.copysign(1.0, ALONG[letter] @ joints[letter].direction) * (-1 if letter in chain.workpiece else 1)
    return "yes" if turns_tool > 0 else "no"


@pytest.mark.parametrize("name", MACHINES)
def test_a_built_in_machine_comes_back(name, tmp_path):
    machine = Machine.load(name)
    letters = "".join(machine.joints)
    text = ini_text(f"trivkins coordinates={letters}", letters, sections=_sections(machine))
    draft = read_control([written(tmp_path, mill_ini=text)], Answers(lambda question: _answer(machine, question)))
    assert not draft.stand_ins
    # a linear joint that moves the workpiece towards +X counts against LinuxCNC's X, which the tool would move along
    senses = np.array([sense(machine, each) for each in machine.joints])
    assert_comes_back(draft.machine, machine, machine.file.chain.spindle_nose, senses)



def test_all_are_tried_but_those_with_inclined_axes_a_b_about_z_or_a_table_that_turns_slides():
    others = {"paper-ab", "xyzab-trunnion-inch", "xyzbc-nutating", "xyzbc-nutating-large"}
    assert set(Machine.names()) - set(MACHINES) == others
