"""Frames as 4 by 4 matrices, as in a textbook; transformations of a program in the order of their programming."""

from __future__ import annotations

import numpy as np


def shift(by):
    made = np.eye(4)
    made[:3, 3] = by
    return made


def turn(axis, degrees):
    """About x (0), y (1) or z (2)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    made = np.eye(4)
    about_x, about_y = [[1, 0, 0], [0, c, -s], [0, s, c]], [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    made[:3, :3] = (about_x, about_y, [[c, -s, 0], [s, c, 0], [0, 0, 1]])[axis]
    return made


def scales(x, y, z):
    return np.diag([x, y, z, 1.0])


def spatial(a, b, c):
    """Spatial angles [deg]: about the fixed axes X, then Y, then Z."""
    return turn(2, c) @ turn(1, b) @ turn(0, a)


def euler(first, middle, last):
    """Precession about z, nutation about the new x, rotation about the new z [deg]."""
    return turn(2, first) @ turn(0, middle) @ turn(2, last)


def of_vectors(x, z):
    """The plane of a normal z and of a direction x, which is laid into it."""
    z = np.asarray(z, float) / np.linalg.norm(z)
    x = np.asarray(x, float) - (np.asarray(x, float) @ z) * z
    x = x / np.linalg.norm(x)
    made = np.eye(4)
    made[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return made


class Chained:
    """Shift, mirror, rotation and scales: each acts in the frame of those that were programmed before it."""

    def __init__(self):
        self.order: list[str] = []
        self.by: dict[str, np.ndarray] = {}
        self.at = np.zeros(3)
        self.angle = 0.0

    def put(self, kind, matrix):
        if kind in self.order and np.array_equal(matrix, np.eye(4)):
            self.order.remove(kind)
        elif not np.array_equal(matrix, np.eye(4)):
            self.by[kind] = matrix
            if kind not in self.order:
                self.order.append(kind)

    def matrix(self):
        made = np.eye(4)
        for kind in self.order:
            made = made @ self.by[kind]
        return made
