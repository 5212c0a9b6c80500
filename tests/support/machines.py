"""Random machines of every class, and an oracle of their kinematics by 4 x 4 matrix products."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from toolpace.machine.file import ChainFile, JointFile, MachineFile
from toolpace.machine.machine import Machine

CLASSES = {"table-table": 2, "head-table": 1, "head-head": 0}


def unit(rng: np.random.Generator) -> np.ndarray:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def random_machine(rng: np.random.Generator, kind: str) -> Machine:
    """Five joints in any order and direction; rotary axes and tool at no less than 10 degrees to each other."""
    far = np.cos(np.radians(10))
    while True:
        rotary = [unit(rng), unit(rng)]
        tool_axis = unit(rng)
        linear = np.array([unit(rng) for _ in range(3)])
        last = rotary[1]
        if abs(rotary[0] @ rotary[1]) < far and abs(last @ tool_axis) < far and abs(np.linalg.det(linear)) > 0.3:
            break
    names = ["L1", "L2", "L3"]
    on_table = CLASSES[kind]
    workpiece = ["R1", "R2"][:on_table][::-1]
    tool = ["R1", "R2"][on_table:]
    for name in names:
        side = workpiece if rng.random() < 0.5 else tool
        side.insert(int(rng.integers(len(side) + 1)), name)
    joints = {}
    for name in rng.permutation(["L1", "L2", "L3", "R1", "R2"]).tolist():
        direction = rotary[int(name[1]) - 1] if name[0] == "R" else linear[int(name[1]) - 1]
        joints[name] = JointFile(
            "rotary" if name[0] == "R" else "linear",
            tuple(3 * direction),
            1.0,
            2.0,
            3.0,
            tuple(rng.normal(size=3)),
            (-9.0, 9.0),
        )
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    chain = ChainFile(
        workpiece=workpiece,
        tool=tool,
        spindle_nose=tuple(rng.normal(size=3)),
        tool_length=0.3 * rng.random(),
        workpiece_origin=tuple(rng.normal(size=3)),
        workpiece_x=tuple(turn[0]),
        workpiece_z=tuple(turn[1]),
        tool_axis=tuple(tool_axis),
    )
    return Machine(MachineFile("random", chain, joints), "random")


def motion(joint: JointFile, q: float) -> np.ndarray:
    """What a joint does to the bodies it carries, (4, 4); rotations by scipy."""
    d = np.array(joint.direction) / np.linalg.norm(joint.direction)
    matrix = np.eye(4)
    if joint.kind == "linear":
        matrix[:3, 3] = q * d
    else:
        matrix[:3, :3] = Rotation.from_rotvec(q * d).as_matrix()
        matrix[:3, 3] = joint.point - matrix[:3, :3] @ joint.point
    return matrix


def oracle(machine: Machine, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tip (3,) and axis (3,) of one joint position, from the bed outwards along both chains."""
    file = machine.file
    position = dict(zip(machine.joints, q))
    table, spindle = np.eye(4), np.eye(4)
    for name in file.chain.workpiece:
        table = table @ motion(file.joints[name], position[name])
    for name in file.chain.tool:
        spindle = spindle @ motion(file.joints[name], position[name])
    a0 = np.array(file.chain.tool_axis) / np.linalg.norm(file.chain.tool_axis)
    nose = np.array(file.chain.spindle_nose)
    z, x = np.array(file.chain.workpiece_z), np.array(file.chain.workpiece_x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = file.chain.workpiece_origin
    seen = np.linalg.inv(table @ frame) @ spindle
    return (seen @ np.append(nose - file.chain.tool_length * a0, 1))[:3], (seen @ np.append(a0, 0))[:3]
