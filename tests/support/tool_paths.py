"""Tool paths made to break a fit, by seed: corners, reversals, rotations in place, specks beside long blocks."""

from __future__ import annotations

import numpy as np

from toolpace.programs.toolpath import ToolPath


def toolpath_through(tip, axis, *, stops=(), dwells=None, rotary=None, joints=(), feed=0.05):
    """A tool path through tip (n, 3) [m] with axes (n, 3), of any length."""
    tip = np.asarray(tip, dtype=float)
    axis = np.asarray(axis, dtype=float)
    n = len(tip)
    stop = np.zeros(n, dtype=bool)
    stop[[0, -1]] = True
    stop[list(stops)] = True
    dwell = np.zeros(n)
    for i, seconds in (dwells or {}).items():
        dwell[i] = seconds
    return ToolPath(
        tip=tip,
        axis=axis / np.linalg.norm(axis, axis=1)[:, None],
        feed=np.full(n, float(feed)),
        least_time=np.zeros(n),
        block=np.arange(1, n + 1),
        stop=stop,
        dwell=dwell,
        rotary=rotary,
        rotary_joints=tuple(joints),
    )


def tilted(a, b):
    """Axes (n, 3) at tilt a about x and turn b about z [rad]."""
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    return np.stack([np.sin(a) * np.sin(b), -np.sin(a) * np.cos(b), np.cos(a)], axis=-1)


def spiral(n):
    """A smooth climbing spiral of n points, rounded to the micrometre."""
    u = np.linspace(0.0, n / 1500.0, n)
    tip = 0.04 * np.stack([np.cos(2 * u), np.sin(2 * u), 0.1 * np.sin(5 * u) + 0.05 * u], axis=1)
    return toolpath_through(np.round(tip, 6), tilted(0.6 + 0.2 * np.sin(2 * u), u))


def rotary_of(a, b):
    """Joint angles (n, 2) with the same meaning for `Fake`."""
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    return np.stack([a, b], axis=-1)


def random_toolpath(seed):
    """Some 5 to 60 blocks of mixed habits, lengths from a micrometre to a decimetre; tilt away from the pole or not."""
    r = np.random.default_rng(seed)
    n = int(r.integers(2, 60))
    length = 10.0 ** r.uniform(-6, -1, n) if r.random() < 0.5 else np.full(n, 10.0 ** r.uniform(-5, -2))
    heading = np.cumsum(r.normal(0, r.choice([0.0, 0.02, 0.5, 2.0]), n))
    climb = r.normal(0, 0.2, n)
    step = np.stack([np.cos(heading), np.sin(heading), climb], axis=1) * length[:, None]
    habit = r.random(n)
    step[habit < 0.08] = 0.0
    step[1:][habit[1:] > 0.93] = -step[:-1][habit[1:] > 0.93]
    tip = np.concatenate([[[0.0, 0.0, 0.0]], np.cumsum(step, axis=0)])
    tip *= min(1.0, 0.15 / max(np.max(np.abs(tip)), 1e-3))
    turn = r.choice([0.0, 0.003, 0.05, 0.3])
    a = 0.4 + np.cumsum(np.concatenate([[0.0], r.normal(0, turn, n) * 0.2]))
    b = np.cumsum(np.concatenate([[0.0], r.normal(0, turn, n)]))
    if np.all(tip == tip[0]) and turn == 0.0:
        tip[-1] += 1e-3
    if r.random() < 0.5:
        tip = np.round(tip, 6)
        if np.all(tip == tip[0]):
            tip[-1] += 1e-3
    stops = tuple(int(i) for i in np.flatnonzero(r.random(n + 1) < 0.05))
    return toolpath_through(tip, tilted(a, b), stops=stops, dwells=dict.fromkeys(stops, 0.1)), rotary_of(a, b)
