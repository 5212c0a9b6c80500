"""Frames as 4 by 4 arrays in millimetres, and the turns that they are made of."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats


def shift(by: Floats) -> Floats:
    """A shift by (3,) mm."""
    made = np.eye(4)
    made[:3, 3] = by
    return made


def turn(axis: Floats, degrees: float | Floats, point: Floats | None = None) -> Floats:
    """A turn about an axis (3,) through a point (3,), by Rodrigues' formula; of angles (n,) as many (n, 4, 4)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.deg2rad(np.asarray(degrees, dtype=float))[..., None, None]
    made = np.zeros((*angle.shape[:-2], 4, 4))
    made[..., :3, :3] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    made[..., 3, 3] = 1.0
    if point is not None:
        made[..., :3, 3] = np.asarray(point) - made[..., :3, :3] @ np.asarray(point)
    return made


def about(slot: int, degrees: float, point: Floats | None = None) -> Floats:
    """A turn about X, Y or Z (0, 1, 2)."""
    return turn(np.eye(3)[slot], degrees, point)


def scaled(factors: Floats) -> Floats:
    """Scales, or where negative mirrors."""
    return np.diag([*factors, 1.0])


def on(frame: Floats, point: Floats) -> Floats:
    """A point (3,) of a frame, in what the frame stands in; or points (n, 3), of one frame or of one each."""
    turned = frame[..., :3, :3] @ np.asarray(point)[..., None]
    return np.asarray(turned[..., 0] + frame[..., :3, 3])


def undo(frame: Floats) -> Floats:
    """The inverse."""
    return np.linalg.inv(frame)


def euler(rotation: Floats) -> tuple[float, float, float]:
    """Angles [deg] about z, the new x, the new z of a rotation (3, 3)."""
    middle = np.arctan2(np.hypot(rotation[0, 2], rotation[1, 2]), rotation[2, 2])
    if np.sin(middle) < 1e-9:
        return float(np.rad2deg(np.arctan2(rotation[1, 0], rotation[0, 0]))), float(np.rad2deg(middle)), 0.0
    first = np.arctan2(rotation[0, 2], -rotation[1, 2])
    last = np.arctan2(rotation[2, 0], rotation[2, 1])
    return float(np.rad2deg(first)), float(np.rad2deg(middle)), float(np.rad2deg(last))


def fixed(rotation: Floats) -> tuple[float, float, float]:
    """Angles [deg] about the fixed axes X, Y, Z of a rotation (3, 3) = Rz Ry Rx."""
    b = np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0]))
    a = np.arctan2(rotation[2, 1], rotation[2, 2])
    c = np.arctan2(rotation[1, 0], rotation[0, 0])
    return float(np.rad2deg(a)), float(np.rad2deg(b)), float(np.rad2deg(c))


def moving(rotation: Floats) -> tuple[float, float, float]:
    """Angles [deg] about X, the new Y, the new Z of a rotation (3, 3) = Rx Ry Rz."""
    a, b, c = fixed(rotation.T)
    return -a, -b, -c
