"""A table-table machine in closed form, written here so that reading is judged without toolpace's own machines."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Floats


class TableTable:
    """X, Y, Z, A, C with the rotary axes through the origin: tool axis (sin C sin A, cos C sin A, cos A)."""

    name = "table-table"
    joints = ("X", "Y", "Z", "A", "C")
    rotary = (3, 4)
    travel = np.full((5, 2), (-np.inf, np.inf))
    tool_length = 0.0

    def rotation(self, a: Floats, c: Floats) -> Floats:
        zero, one = np.zeros_like(a), np.ones_like(a)
        about_c = [[np.cos(c), np.sin(c), zero], [-np.sin(c), np.cos(c), zero], [zero, zero, one]]
        about_a = [[one, zero, zero], [zero, np.cos(a), np.sin(a)], [zero, -np.sin(a), np.cos(a)]]
        return np.moveaxis(np.array(about_c), -1, 0) @ np.moveaxis(np.array(about_a), -1, 0)

    def forward(self, q: Floats, /) -> tuple[Floats, Floats]:
        rotation = self.rotation(q[:, 3], q[:, 4])
        return np.einsum("nij,nj->ni", rotation, q[:, :3]), rotation[:, :, 2]

    def rotary_solutions(self, axis: Floats, /) -> tuple[Floats, Bools]:
        tilt = np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
        turn = np.where(tilt > 0.0, np.arctan2(axis[:, 0], axis[:, 1]), 0.0)
        both = np.stack([np.stack([tilt, turn], axis=1), np.stack([-tilt, turn + np.pi], axis=1)], axis=1)
        return both, tilt <= 0.0


MACHINE = TableTable()
