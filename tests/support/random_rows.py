"""Programs as rows of poses, by seed, of habits that confuse a matching; and motions along them, right and wrong."""

from __future__ import annotations

import numpy as np

HABITS = ("wander", "retrace", "peck", "loops", "spiral", "zigzag", "turns", "specks", "crossing")


def random_program(r, habit, tolerances=6.0):
    """A row of 3 to 40 poses (m, 6) [tolerances]: tip and tool axis, with lengths about `tolerances`."""
    n = int(r.integers(3, 30))
    size = tolerances * 10.0 ** r.uniform(-1.0, 1.0)
    line = np.zeros((n, 6))
    if habit == "wander":
        line = np.cumsum(r.normal(0.0, size, (n, 6)) * (r.random(6) < 0.6), axis=0)
    elif habit == "retrace":
        corners = np.cumsum(r.normal(0.0, size, (int(r.integers(2, 6)), 6)), axis=0)
        line = np.concatenate([corners if k % 2 == 0 else corners[::-1] for k in range(int(r.integers(2, 6)))])
        line = line[np.concatenate(([True], np.any(np.diff(line, axis=0) != 0.0, axis=1)))]
    elif habit == "peck":
        depth = np.sort(r.uniform(0.0, 10.0 * size, max(n // 3, 1)))
        rows = [[0.0, 0.0]]
        for k, d in enumerate(depth):
            back = d - r.uniform(0.2, 2.0) if r.random() < 0.5 else 0.0
            rows += [[k * size * (r.random() < 0.2), -d], [0.0, -back]]
        line = np.zeros((len(rows), 6))
        line[:, [0, 2]] = rows
    elif habit == "loops":
        turn = np.linspace(0.0, r.uniform(1.0, 4.0) * 2.0 * np.pi, n)
        line[:, 0], line[:, 1] = size * np.cos(turn) + r.uniform(0.0, 0.5) * size * turn, size * np.sin(turn)
    elif habit == "spiral":
        turn = np.linspace(0.0, r.uniform(2.0, 5.0) * 2.0 * np.pi, n)
        radius = r.uniform(0.05, 1.0) * turn
        line[:, 0], line[:, 1] = radius * np.cos(turn), radius * np.sin(turn)
        line[:, 3] = 0.3 * turn
    elif habit == "zigzag":
        line[:, 3] = np.where(np.arange(n) % 2, size, 0.0) * r.uniform(0.2, 1.0)
        line[:, 0] = np.arange(n) * r.choice([0.0, 0.1, 1.0]) * size
    elif habit == "turns":
        turn = np.arange(n) * r.uniform(0.5, 2.0)
        radius = r.choice([0.3, 0.6, 0.95, 1.5, 3.0])
        line[:, 3], line[:, 4] = radius * np.cos(turn), radius * np.sin(turn)
    elif habit == "specks":
        line = np.cumsum(r.normal(0.0, size, (n, 6)) * 10.0 ** r.uniform(-3.0, 0.0, (n, 1)), axis=0)
    else:
        line[:, 0] = np.cumsum(r.choice([-1.0, 1.0, 1.0], n)) * size
        line[:, 1] = np.cumsum(r.choice([-1.0, 0.0, 1.0], n)) * size
    return line


def place_on(line, place):
    """Poses (k, 6) at places (k,) of a row."""
    j = np.minimum(place.astype(int), len(line) - 2)
    return line[j] + (place - j)[:, None] * (line[j + 1] - line[j])


def along(r, line, *, within=0.6, corners=True, dense=4):
    """A motion in order along a row: some places between its poses, each off it by at most `within`; dwells."""
    m = len(line) - 1
    place = np.sort(r.uniform(0.0, m, int(r.integers(2, dense * m + 3))))
    place = np.unique(np.concatenate((place, np.arange(m + 1.0) if corners else [0.0, m])))
    if r.random() < 0.3:
        place = np.sort(np.concatenate((place, np.repeat(r.choice(place), 5))))
    motion = place_on(line, place)
    off = r.normal(0.0, 1.0, motion.shape)
    for half in (slice(0, 3), slice(3, 6)):
        off[:, half] *= (within * r.random(len(off)) / np.linalg.norm(off[:, half], axis=1))[:, None]
    return motion + off


def spoilt(r, motion):
    """The motion, wrong in one of many ways."""
    n = len(motion)
    i, j = sorted(int(k) for k in r.integers(0, n, 2))
    kind = int(r.integers(0, 6))
    if kind == 0:  # a part left out
        return np.concatenate((motion[: i + 1], motion[max(j, i + 1) :]))
    if kind == 1:  # a part the other way round
        return np.concatenate((motion[:i], motion[i : j + 1][::-1], motion[j + 1 :]))
    if kind == 2:  # a place that is off
        moved = motion.copy()
        moved[i] += r.normal(0.0, 1.0, 6) * r.choice([1.05, 1.5, 3.0, 100.0])
        return moved
    if kind == 3:  # two parts exchanged
        k = (i + j) // 2
        return np.concatenate((motion[:i], motion[k:j], motion[i:k], motion[j:]))
    if kind == 4:  # back and on again
        return np.concatenate((motion[: j + 1], motion[i : j + 1][::-1], motion[i:]))
    return motion[: max(j, 2)] if r.random() < 0.5 else motion[min(i, n - 2) :]
