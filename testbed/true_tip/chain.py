"""A machine file as rotation matrices: where tool tip and tool axis are, with a tool of some length."""

from __future__ import annotations

import math
import tomllib

import numpy as np

LENGTHS, ANGLES = {"m": 1.0, "mm": 1e-3, "in": 0.0254}, {"rad": 1.0, "deg": math.pi / 180.0}


def rotation(axis, angle):
    """(n, 3, 3) matrices of turns about an axis (3,) by angles (n,) [rad]: Rodrigues' formula."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.asarray(angle, float)[:, None, None]
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


class Chain:
    """Two chains of joints from the bed, in metres and radians."""

    def __init__(self, text):
        told = tomllib.loads(text)
        length = LENGTHS[told.get("units", {}).get("length", "m")]
        angle = ANGLES[told.get("units", {}).get("angle", "rad")]
        chain = told["chain"]
        self.names = list(told["joints"])
        self.workpiece, self.tool = list(chain["workpiece"]), list(chain["tool"])
        self.origin = length * np.array(chain["workpiece_origin"], float)
        self.nose = length * np.array(chain["spindle_nose"], float)
        self.axis = np.array(chain.get("tool_axis", [0, 0, 1]), float)
        self.axis = self.axis / np.linalg.norm(self.axis)
        self.own_length = length * chain["tool_length"]
        self.rotary = [name for name in self.names if told["joints"][name]["kind"] == "rotary"]
        self.linear = [name for name in self.names if name not in self.rotary]
        self.direction = {n: np.array(told["joints"][n]["direction"], float) for n in self.names}
        self.direction = {n: v / np.linalg.norm(v) for n, v in self.direction.items()}
        self.point = {n: length * np.array(told["joints"][n].get("point", [0, 0, 0]), float) for n in self.names}
        x = np.array(chain.get("workpiece_x", [1, 0, 0]), float)
        z = np.array(chain.get("workpiece_z", [0, 0, 1]), float)
        self.place(x, z)
        unit = {n: angle if n in self.rotary else length for n in self.names}
        self.travel = {
            n: unit[n] * np.array(told["joints"][n].get("travel", [-1e9, 1e9]), float) for n in self.names
        }

    def place(self, x, z):
        """Turn the part so that its X and Z are along directions (3,) of the bed, with every joint at zero."""
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        self.frame = np.stack([x, np.cross(z, x), z], axis=1)

    def _carried(self, chain, q, point):
        """Rotations (n, 3, 3) of a chain at joints (n, m), and where it carries a point (3,) of the bed (n, 3)."""
        turned, place = np.tile(np.eye(3), (len(q), 1, 1)), np.tile(point, (len(q), 1))
        for name in reversed(chain):
            value = q[:, self.names.index(name)]
            if name in self.rotary:
                by = rotation(self.direction[name], value)
                place = np.einsum("nij,nj->ni", by, place - self.point[name]) + self.point[name]
                turned = by @ turned
            else:
                place = place + value[:, None] * self.direction[name]
        return turned, place

    def forward(self, q, length):
        """Tips (n, 3) [m] and axes (n, 3) on the part, at joints (n, m), of a tool of a length [m]."""
        q = np.atleast_2d(np.asarray(q, float))
        head, tip = self._carried(self.tool, q, self.nose - length * self.axis)
        table, origin = self._carried(self.workpiece, q, self.origin)
        to_part = self.frame.T @ np.swapaxes(table, 1, 2)
        return np.einsum("nij,nj->ni", to_part, tip - origin), np.einsum("nij,njk,k->ni", to_part, head, self.axis)

    def joints(self, tip, rotary, length):
        """Joints (n, m) that bring the tip of a tool to places (n, 3) with its rotary joints, by name, at (n,) each."""
        q = np.zeros((len(tip), len(self.names)))
        for name, value in rotary.items():
            q[:, self.names.index(name)] = value
        base = self.forward(q, length)[0]
        columns = np.empty((len(tip), 3, 3))
        for k, name in enumerate(self.linear):
            moved = q.copy()
            moved[:, self.names.index(name)] += 1.0
            columns[:, :, k] = self.forward(moved, length)[0] - base
        slides = [self.names.index(name) for name in self.linear]
        q[:, slides] = np.linalg.solve(columns, (tip - base)[..., None])[..., 0]
        return q

    def within(self, q, room=2e-3):
        """Whether joints (n, m) are inside travel, by some room [m or rad]."""
        low, high = np.array([self.travel[name] for name in self.names]).T
        return bool((q >= low + room).all() and (q <= high - room).all())
