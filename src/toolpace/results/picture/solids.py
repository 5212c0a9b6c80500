"""Triangles of plain bodies: of revolution, and boxes; and of the bodies that stand for a machine's joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats

FACETS = 48
"""Around an axis."""
TABLES = ((0.30, 0.36, 0.45), (0.25, 0.30, 0.38), (0.20, 0.25, 0.31))
SPINDLE, HEADS = (0.49, 0.55, 0.64), ((0.39, 0.45, 0.55), (0.30, 0.36, 0.45))
"""Colours."""


def frame_about(axis: Floats) -> Floats:
    """(3, 3) whose rows are two directions across a unit vector, and that vector; right-handed."""
    helper = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis])


def revolved(outline: Floats, foot: Floats, axis: Floats) -> Floats:
    """(n, 3, 3) of a body of heights and radii (k, 2) along an axis from a foot, closed at both ends."""
    ends = np.concatenate([[[outline[0, 0], 0.0]], outline, [[outline[-1, 0], 0.0]]])
    angle = 2.0 * np.pi * np.arange(FACETS + 1) / FACETS
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ frame_about(axis)[:2]
    ring = foot + ends[:, None, 0, None] * axis + ends[:, None, 1, None] * around
    a, b, c, d = ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]
    quads = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    return quads.reshape(-1, 3, 3)


def cylinder(centre: Floats, axis: Floats, radius: float, length: float, lower: float | None = None) -> Floats:
    """(n, 3, 3); `lower` is the radius at the end against the axis, where it is another."""
    low = radius if lower is None else lower
    return revolved(np.array([[-0.5 * length, low], [0.5 * length, radius]]), centre, axis)


def box(centre: Floats, x: Floats, z: Floats, sides: tuple[float, float, float]) -> Floats:
    """(12, 3, 3) with sides along x, across both, and about along z."""
    y = np.cross(z, x)
    y = y / np.linalg.norm(y) if np.linalg.norm(y) > 1e-6 else frame_about(x)[0]
    axes = np.stack([x, y, np.cross(x, y)]) * 0.5 * np.array(sides)[:, None]
    corner = np.array([[(k >> d & 1) * 2.0 - 1.0 for d in range(3)] for k in range(8)]) @ axes + centre
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    found: Floats = corner[np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])]
    return found


@dataclass(frozen=True)
class MachineBody:
    """A plain body on a joint, in the bed's frame with all joints at zero [m]."""

    triangles: Floats
    colour: tuple[float, float, float]
    chain: str
    """"workpiece" or "tool_chain"."""
    joint: int
    """Index in the chain of the joint that carries it; -1: the bed."""


def machine_bodies(view: dict[str, Any], low: Floats, high: Floats) -> list[MachineBody]:
    """Tables and spindle of a machine as `machine_view` tells it, for a part between two corners (3,) [m].

    They are those of player/scene.js, so that a picture and the report show one machine.
    """
    up, size = np.array(view["axis"]), float(np.linalg.norm(high - low))
    place = bodies_at(view["workpiece"], np.zeros(99))[-1] @ origin_of(view) if view["workpiece"] else origin_of(view)
    corners = np.array([[(low, high)[k >> d & 1][d] for d in range(3)] for k in range(8)])
    corners = corners @ place[:3, :3].T + place[:3, 3]
    return [*_tables(view["workpiece"], up, size, corners), *_spindle(view, up, size)]


def _tables(joints: list[dict[str, Any]], up: Floats, size: float, corners: Floats) -> list[MachineBody]:
    centre, held, thick = corners.mean(axis=0), 0.52 * size, 0.1 * size
    level = float((corners @ up).min()) - 0.02 * size
    found = []
    if not joints:
        plate = centre + (level - 0.5 * thick - centre @ up) * up
        bed = box(plate, frame_about(up)[0], up, (3.0 * held, 3.0 * held, thick))
        found.append(MachineBody(bed, TABLES[1], "workpiece", -1))
    for back, k in enumerate(reversed(range(len(joints)))):
        joint, colour = joints[k], TABLES[back % 3]
        u = np.array(joint["direction"])
        if joint["rotary"]:
            on_axis = nearest_on(joint, centre)
            plate = on_axis + (level - 0.5 * thick - on_axis @ up) * up
            if abs(u @ up) > 0.7:
                found.append(MachineBody(cylinder(plate, up, held, thick), colour, "workpiece", k))
                held *= 1.12
            else:
                for side in (-1.2, 1.2):
                    cheek = cylinder(on_axis + side * held * u, u, 0.26 * size, 0.18 * size)
                    found.append(MachineBody(cheek, colour, "workpiece", k))
                found.append(MachineBody(box(plate, u, up, (2.4 * held, 1.1 * held, thick)), colour, "workpiece", k))
        elif abs(u @ up) < 0.7:
            plate = centre + (level - 0.5 * thick - centre @ up) * up
            sides = 2.875 * held, 2.25 * held, thick
            found.append(MachineBody(box(plate, u, up, sides), colour, "workpiece", k))
        level -= thick
    return found


def _spindle(view: dict[str, Any], up: Floats, size: float) -> list[MachineBody]:
    reach, nose = 1e-3 * view["length"], 1e-3 * np.array(view["nose"])
    wide, tall = min(0.3 * reach, 0.35 * size), max(0.9 * reach, 0.5 * size)
    joints = view["tool_chain"]
    quill = cylinder(nose + 0.5 * tall * up, up, wide, tall, 0.8 * wide)
    found = [MachineBody(quill, SPINDLE, "tool_chain", len(joints) - 1)]
    for back, k in enumerate(reversed(range(len(joints)))):
        if joints[k]["rotary"]:
            u = np.array(joints[k]["direction"])
            head = cylinder(nearest_on(joints[k], nose + tall * up), u, 1.1 * wide, 1.7 * wide)
            found.append(MachineBody(head, HEADS[back % 2], "tool_chain", k))
    return found


def nearest_on(joint: dict[str, Any], place: Floats) -> Floats:
    """The point of a rotary joint's axis that is nearest to a place (3,) [m]."""
    point, u = 1e-3 * np.array(joint["point"]), np.array(joint["direction"])
    found: Floats = point + ((place - point) @ u) * u
    return found


def origin_of(view: dict[str, Any]) -> Floats:
    """(4, 4) the frame of the part on its table, with all joints at zero [m]."""
    place = np.eye(4)
    # columns are the directions of the workpiece
    place[:3, :3] = np.array(view["orientation"]).reshape(3, 3).T
    place[:3, 3] = 1e-3 * np.array(view["origin"])
    return place


def bodies_at(joints: list[dict[str, Any]], q: Floats) -> list[Floats]:
    """(4, 4) the motion of the body of each joint from where it is at zero, at positions q [m], [rad]."""
    found, place = [], np.eye(4)
    for joint in joints:
        step, u, value = np.eye(4), np.array(joint["direction"]), float(q[joint["column"]])
        if joint["rotary"]:
            cross = np.cross(np.eye(3), u)
            step[:3, :3] = np.eye(3) + np.sin(value) * cross + (1.0 - np.cos(value)) * cross @ cross
            point = 1e-3 * np.array(joint["point"])
            step[:3, 3] = point - step[:3, :3] @ point
        else:
            step[:3, 3] = value * u
        place = place @ step
        found.append(place)
    return found
