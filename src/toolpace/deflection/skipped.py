"""The stretches of the path that the tip leaves out on a way back onto it, from the way and the path alone."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.units import format_length
from toolpace.deflection.compensation import CompensatedRun
from toolpace.deflection.detour import DetourRun
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Skipped

LEFT_OUT = 1e-5
"""Distance from the tip's way beyond which a point of the path is left out: the tolerance that a fit and the judge take
where no other is given [m]; without a machine of the joints."""
SPACING = 5e-5
"""Wanted between two points of path and way [m]: a chord of it is within 0.3 um of an arc of 1 mm."""
FEWEST, MOST_POINTS = 64, 1024
"""Points of path and way each: enough for a short one, and what costs 20 ms for a long one."""


def skipped_by(run: DetourRun, place: float) -> tuple[Skipped, ...]:
    """What a detour leaves out from a place of it on, in the order of the path."""
    detour, followed = run.detour, run.rest_of
    if not run.on_detour(np.array([place]))[0]:
        return ()
    begin = float(run.time_at(np.array([place]))[0])
    compensation = followed.compensation if isinstance(followed, CompensatedRun) else None
    path = followed.base if isinstance(followed, CompensatedRun) else followed
    start = float(detour.abreast(np.array([begin]))[0])
    if run.leads_to_start or not start < run.join or not begin < detour.duration:
        return ()

    def tips(count: int) -> tuple[Floats, Floats, Floats]:
        """Parameters (count,), the path there and the way, (count, c) each."""
        s, t = np.linspace(start, run.join, count), np.linspace(begin, detour.duration, count)
        way = tip_of(run.machine, detour.motion(t)[0])
        return s, tip_of(run.machine, path.evaluate(s)[0]), way if compensation is None else way - compensation.offset

    s, on_path, way = tips(FEWEST)
    longest = max(float(np.linalg.norm(np.diff(each, axis=0), axis=1).sum()) for each in (on_path, way))
    if longest > FEWEST * SPACING:
        s, on_path, way = tips(int(min(longest / SPACING, MOST_POINTS)))
    off = distances(on_path, way)
    steps = np.linalg.norm(np.diff(on_path, axis=0), axis=1)
    out = np.concatenate([[False], off > LEFT_OUT, [False]])
    firsts, ends = np.flatnonzero(out[1:] & ~out[:-1]), np.flatnonzero(out[:-1] & ~out[1:])
    found = []
    for first, end in zip(firsts, ends):
        low, high = max(int(first) - 1, 0), min(int(end), len(s) - 1)
        blocks = path.block_at(s[[low, high]])
        length = float(steps[low:high].sum())
        found.append(Skipped(float(s[low]), float(s[high]), length, float(off[first:end].max()), *map(int, blocks)))
    # where the path stands still there is no length to leave out
    return tuple(each for each in found if each.length > 0.0)


def skipped_in_words(skipped: Skipped, machine: Machine | None) -> str:
    """One line for people."""
    first, last = skipped.first_block, skipped.last_block
    blocks = "" if not first else f", block {first}" if first == last else f", blocks {first} to {last}"
    length, off = (
        (format_length(value) if machine is not None else f"{value:.4g} of the joints")
        for value in (skipped.length, skipped.off)
    )
    where = f"from s = {skipped.start:.6g} to {skipped.end:.6g}{blocks}"
    return f"the path is left out {where}: {length}, up to {off} off the way of the tip"


def tip_of(machine: Machine | None, q: Floats) -> Floats:
    """(n, 3) tips of joints (n, m) [m]; without a machine the joints."""
    return q if machine is None else machine.forward(q)[0]


def distances(points: Floats, way: Floats) -> Floats:
    """(n,) distance of points (n, c) from the chords of a way (k, c), beside its nearest corner."""
    square = (points**2).sum(axis=1)[:, None] + (way**2).sum(axis=1) - 2.0 * points @ way.T
    k = np.argmin(square, axis=1)
    sides = [from_chord(points, way[np.maximum(k - 1, 0)], way[k])]
    sides.append(from_chord(points, way[k], way[np.minimum(k + 1, len(way) - 1)]))
    return np.minimum(*sides)


def from_chord(points: Floats, begin: Floats, end: Floats) -> Floats:
    """(n,) distance of points (n, c), each from a chord of its own."""
    along = end - begin
    square = np.einsum("nc,nc->n", along, along)
    share = np.einsum("nc,nc->n", points - begin, along) / np.where(square > 0.0, square, 1.0)
    distance: Floats = np.linalg.norm(begin + np.clip(share, 0.0, 1.0)[:, None] * along - points, axis=1)
    return distance
