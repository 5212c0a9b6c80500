"""A pass over a saddle whose tool axis swings: what a set-up changes much of."""

from __future__ import annotations

import numpy as np

from toolpace.programs.toolpath import ToolPath


def curved_pass(points: int = 60, lean: float = 50.0, feed: float = 0.5) -> ToolPath:
    """120 mm long; the axis swings by `lean` [deg] along it, and by 25 deg across."""
    u = np.linspace(0.0, 1.0, points)
    tip = np.column_stack([0.12 * (u - 0.5), 0.02 * np.sin(2.0 * np.pi * u), 0.015 * np.cos(2.0 * np.pi * u)])
    along, across = np.radians(lean) * np.sin(2.5 * np.pi * u + 0.3), np.radians(25.0) * np.cos(3.0 * np.pi * u)
    axis = np.column_stack([np.sin(along) * np.cos(across), np.sin(across), np.cos(along) * np.cos(across)])
    return ToolPath(
        tip, axis / np.linalg.norm(axis, axis=1)[:, None], np.full(points, feed), np.zeros(points),
        np.arange(1, points + 1), np.isin(np.arange(points), [0, points - 1]), np.zeros(points),
    )  # fmt: skip
