"""Frames as 4 by 4 matrices, from the sentences of the manuals."""

from __future__ import annotations

import numpy as np

from testbed.true_tip.chain import rotation

AXES = dict(zip("XYZ", np.eye(3)))


def shift(by):
    """A shift by (3,)."""
    made = np.eye(4)
    made[:3, 3] = by
    return made


def linear(matrix):
    """A turn, scale or mirror (3, 3)."""
    made = np.eye(4)
    made[:3, :3] = matrix
    return made


def about(letter, degrees):
    """(3, 3) turn about X, Y or Z."""
    return rotation(AXES[letter], [np.radians(degrees)])[0]


def rpy(angles):
    """(3, 3) of `ROT X.. Y.. Z..` in one block: about Z, then the new Y, then the newest X."""
    return about("Z", angles.get("Z", 0.0)) @ about("Y", angles.get("Y", 0.0)) @ about("X", angles.get("X", 0.0))


def solid(angles):
    """(3, 3) of ROTS with two angles.

    Of axes in the cyclic order first, second, third: the first is turned about the second by that one's angle, which
    keeps it in the plane of first and third; the second is turned about the first by that one's; both span the plane.
    """
    third = next(letter for letter in "XYZ" if letter not in angles)
    first = "XYZ"[("XYZ".index(third) + 1) % 3]
    second = "XYZ"[("XYZ".index(third) + 2) % 3]
    one = about(second, angles[second]) @ AXES[first]
    other = about(first, angles[first]) @ AXES[second]
    normal = np.cross(one, other)
    normal /= np.linalg.norm(normal)
    made = np.zeros((3, 3))
    made[:, "XYZ".index(first)], made[:, "XYZ".index(third)] = one, normal
    made[:, "XYZ".index(second)] = np.cross(normal, one)
    return made


def least_turn(direction):
    """(3, 3) turn of Z to a unit vector about an axis square to both: X and Y are equally far from their old planes."""
    axis = np.cross([0.0, 0.0, 1.0], direction)
    size = np.linalg.norm(axis)
    return np.eye(3) if size < 1e-12 else rotation(axis / size, [np.arctan2(size, direction[2])])[0]


def of_angles(kind, a, b, c):
    """(3,) tool direction of A2, B2, C2: ORIEULER about Z, X', Z''; ORIRPY by C2 about Z, B2 about Y', A2 about X''."""
    if kind == "ORIEULER":
        return (about("Z", a) @ about("X", b) @ about("Z", c))[:, 2]
    return (about("Z", c) @ about("Y", b) @ about("X", a))[:, 2]
