"""What a reader made of a program, against the motions that the model says it means."""

from __future__ import annotations

import numpy as np

from testbed.one_program.motion import STILL, Move, World
from toolpace.common.arrays import Floats
from toolpace.programs.toolpath import ToolPath

FINE = 1e-9
"""Most difference: of places by the size of the motion, of angles [rad], of times by themselves."""
TINY = 1e-9


class Poses:
    """The points of a tool path, in the model's units, without those that a rounding alone makes."""

    def __init__(self, path: ToolPath, world: World) -> None:
        self.path = path
        self.tip = np.asarray(path.tip) * 1e3
        self.axis = np.asarray(path.axis)
        self.rotary = None
        if path.rotary is not None:
            order = [path.rotary_joints.index(letter) for letter in world.machine.letters]
            self.rotary = np.rad2deg(np.asarray(path.rotary)[:, order])
        self.size = max(1.0, float(np.abs(self.tip).max()))

    def off(self, points: slice, poses: tuple[Floats, Floats, Floats]) -> Floats:
        """How far points are from poses, each as a share of what it may be."""
        tip, axis, rotary = poses
        worst = np.abs(self.tip[points] - tip).max(axis=1) / self.size
        worst = np.maximum(worst, np.abs(self.axis[points] - axis).max(axis=1))
        if self.rotary is not None:
            worst = np.maximum(worst, np.deg2rad(np.abs(self.rotary[points] - rotary).max(axis=1)))
        return np.asarray(worst / FINE)


def shares(move: Move, poses: Poses, points: slice) -> Floats:
    """The shares of a motion at which points behind its start stand, if they are its own."""
    if move.turns and poses.rotary is not None:
        way = move.rotary[1] - move.rotary[0]
        return np.asarray((poses.rotary[points] - move.rotary[0]) @ way / (way @ way))
    place = place_of(move, poses, points)
    circle = move.circle
    if circle is None:
        way = move.end - move.start
        return np.asarray((place - move.start) @ way / (way @ way))
    spoke = place - circle.centre
    angle = np.unwrap(np.concatenate([[0.0], np.arctan2(spoke @ circle.w, spoke @ circle.u)]))
    return np.asarray(angle[1:] / circle.sweep)


def place_of(move: Move, poses: Poses, points: slice) -> Floats:
    """X, Y, Z of points in the space of the motion."""
    world = move.world
    tip = poses.tip[points]
    if not move.slides:
        return np.asarray(tip)
    linear = world.machine.linear(tip, move.rotary[1], move.length_of_tool)
    return np.asarray(linear - world.home(move.length_of_tool))


def difference(path: ToolPath, world: World) -> str:
    """The first difference, in words; empty where there is none."""
    poses = Poses(path, world)
    moves = world.moves if poses.rotary is not None else seen_by_points(world.moves)
    if (found := poses.off(slice(0, 1), moves[0].pose(1.0))[0]) > 1.0:
        return f"begins {found:.3g} off: {poses.tip[0]} for {moves[0].end}"
    k = 1
    for number, move in enumerate(moves[1:], 1):
        k, fault = followed(path, poses, move, k)
        if fault:
            return f"motion {number} of {len(moves) - 1}, line {path.block[min(k, len(path) - 1)]}: {fault}"
        if fault := states(path, move, k - 1, last=number == len(moves) - 1):
            return f"behind motion {number}, line {path.block[k - 1]}: {fault}"
    return "" if k == len(path) else f"{len(path) - k} points too many, from line {path.block[k]}"


def seen_by_points(moves: list[Move]) -> list[Move]:
    """Motions without those that neither move the tip nor turn the tool: points do not tell them."""
    kept = moves[:1]
    for move in moves[1:]:
        before, after = move.pose(0.0), move.pose(1.0)
        still = max(float(np.abs(a - b).max()) for a, b in zip(before[:2], after[:2])) <= STILL
        if still and move.circle is None:
            kept[-1].stop, kept[-1].dwell = kept[-1].stop or move.stop, kept[-1].dwell + move.dwell
        else:
            kept.append(move)
    return kept


def length_of(move: Move, poses: Poses) -> float:
    """The way that a feed speaks of [mm]."""
    if poses.rotary is None and move.turns and move.slides:
        return float(np.linalg.norm(move.pose(1.0)[0] - move.pose(0.0)[0]))
    return move.length


def followed(path: ToolPath, poses: Poses, move: Move, first: int) -> tuple[int, str]:
    """The point behind a motion that begins before point `first`, and what is wrong with it."""
    if first >= len(path):
        return first, "is not there"
    end = move.pose(1.0)
    points = slice(first, first + 1) if poses.rotary is None and move.turns else extent(move, poses, first, len(path))
    t = np.array([1.0]) if poses.rotary is None and move.turns else shares(move, poses, points)
    rapid = np.asarray(path.rapid[points])
    if (rapid != move.rapid).any():
        return first + int(np.argmax(rapid != move.rapid)), "a feed for rapid" if move.rapid else "rapid for a feed"
    rise = np.diff(np.concatenate([[0.0], t]))
    off = poses.off(points, move.pose(t))
    wrong = (rise <= -TINY) | (t > 1.0 + 1e-6) | (off > 1.0)
    if wrong.any():
        k = int(np.argmax(wrong))
        return first + k, f"is {off[k]:.3g} off at {t[k]:.9g}: {poses.tip[first + k]}, on the way to {end[0]}"
    if t[-1] < 1.0 - 1e-6 or poses.off(slice(points.stop - 1, points.stop), end)[0] > 1.0:
        return points.stop, f"ends at {t[-1]:.9g} of it"
    least, speed = np.asarray(path.least_time[points]), np.asarray(path.feed[points]) * 1e3
    with np.errstate(invalid="ignore"):
        seconds = float(np.where(least > 0.0, least, length_of(move, poses) * rise / speed).sum())
    if not move.rapid and abs(seconds - move.seconds) > 1e-8 * move.seconds:
        return points.stop - 1, f"takes {seconds:.12g} s for {move.seconds:.12g}"
    return points.stop, ""


def extent(move: Move, poses: Poses, first: int, count: int) -> slice:
    """The points from `first` to the first at the end of a motion; all that are left where there is none."""
    size = 32
    while True:
        points = slice(first, min(first + size, count))
        t = shares(move, poses, points)
        there = (t > 1.0 - 1e-6) & (poses.off(points, move.pose(1.0)) <= 1.0)
        if there.any():
            return slice(first, first + int(np.argmax(there)) + 1)
        if points.stop == count or (t > 1.5).any():
            return points
        size *= 8


def states(path: ToolPath, move: Move, k: int, *, last: bool) -> str:
    """What is wrong with stop and dwell at the end of a motion."""
    if bool(path.stop[k]) != (move.stop or last):
        return "a stop that is none" if path.stop[k] else "no stop"
    if abs(path.dwell[k] - move.dwell) > FINE:
        return f"waits {path.dwell[k]:.9g} s for {move.dwell:.9g}"
    return ""
