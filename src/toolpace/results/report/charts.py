"""Data of the report's charts: curves over time with their peaks kept, and the limit that binds."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.machine.limit_curves import CurvedLimit
from toolpace.machine.limits import KINDS, MOTORS, Limits
from toolpace.motion.sampling import each_block
from toolpace.motion.setpoints import Block, SetPoints, SetPointSource
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath

POINTS = 40_000
"""Points of each channel in the file, and line numbers: twenty for each pixel of a wide screen."""
BINDING = 0.99
"""Share of a limit from which it is shown as binding."""
NOTHING = -1
"""Stands where nothing binds, in place of the number of a limit."""
COLUMNS = {"velocity": "qd", "acceleration": "qdd", "jerk": "qddd"}
"""Where the values of a panel are from."""
SPEED, CAP = "tip speed", "feed in the program"
"""Names of the curves of what the tip does, and of what the program allows."""


@dataclass(frozen=True)
class Channel:
    """One curve: what it is, and its values at the set-points, or the extremes of stretches of them."""

    name: str
    panel: str
    """"feed", "deviation", "velocity", "acceleration" or "jerk"."""
    joint: int
    """Number of the joint; -1 for the tip, -2 for the tool axis."""
    values: Floats
    """(n,) in what the panel shows: a share of the limit, or mm/min."""
    peak: float = 1.0
    """What 1 stands for, in the unit below."""
    unit: str = ""
    top: float = 0.0
    """The largest value that a stretch without one at some set-point hides."""


def tip_speed(setpoints: SetPoints) -> Floats:
    """(n,) speed of the tip [m/s] by differences over one step each way."""
    if not setpoints.has_tool or len(setpoints) < 2:
        return np.zeros(0)
    return _at_both_ends(setpoints.tip_steps / np.diff(setpoints.t))


def _at_both_ends(step: Floats) -> Floats:
    """(n,) the mean of the steps (n - 1,) beside each set-point."""
    speed: Floats = np.concatenate((step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]))
    return speed


class FeedCaps:
    """The feed that a program asks for in each of its blocks: the largest, where one has several ways."""

    def __init__(self, toolpath: ToolPath) -> None:
        self.blocks, where = np.unique(toolpath.block[1:], return_inverse=True)
        self.most = np.zeros(len(self.blocks))
        np.maximum.at(self.most, where, toolpath.most_speed[1:])

    def at(self, block: Ints) -> Floats:
        """(n,) that of blocks (n,) [m/s]; inf where the program asks for none."""
        if not len(self.blocks):
            return np.full(len(block), np.inf)
        at = np.clip(np.searchsorted(self.blocks, block), 0, len(self.blocks) - 1)
        found: Floats = np.where(self.blocks[at] == block, self.most[at], np.inf)
        return found


def _named_curves(has_tool: bool, limits: Limits, units: list[str], toolpath: ToolPath | None) -> list[Channel]:
    """All curves, without values."""
    none, found = np.zeros(0), []
    if has_tool:
        found.append(Channel(SPEED, "feed", -1, none, 1.0, "mm/min"))
        found += [Channel(CAP, "feed", -1, none, 1.0, "mm/min")] if toolpath is not None else []
    per = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}
    for kind in KINDS:
        for j, joint in enumerate(limits.joints):
            limit = float(getattr(limits, kind)[j])
            if np.isfinite(limit):
                scale = {"m": 1e3, "rad": 180.0 / np.pi}.get(units[j], 1.0)
                unit = {"m": "mm", "rad": "°"}.get(units[j], "") + per[kind]
                found.append(Channel(joint, kind, j, none, limit * scale, unit))
    return found


def deviations(
    trajectory: Trajectory, source: SetPointSource, tip_mm: float | None, axis_deg: float | None
) -> list[Channel]:
    """Curves of how far the path is off the program at set-points, as shares of the tolerances [mm], [deg]; none
    where that is not known. The largest that was found in the piece of the path that is passed; of many the
    extremes."""
    found = [run.deviations() for run in trajectory.axis_path.runs]
    of_runs = [each for each in found if each is not None]
    if len(of_runs) < len(found) or tip_mm is None or axis_deg is None:
        return []
    edges = stretches(len(source))
    # pieces are passed in order: those of a stretch lie between those of its ends
    many = len(edges) <= len(source)
    t = source.times(np.concatenate((edges[:-1], edges[1:] - 1)) if many else edges[:-1])
    s, run = trajectory.parameter(t), trajectory.run_at(t)
    piece = np.zeros(len(t), dtype=np.int64)
    pieces = 0
    for k, (breaks, *_) in enumerate(of_runs):
        of_run = run == k
        last = len(breaks) - 2
        piece[of_run] = pieces + np.clip(np.searchsorted(breaks, s[of_run], side="right") - 1, 0, last)
        pieces += last + 1
    channels = []
    for k, (name, tolerance, unit) in enumerate((("tip", tip_mm * 1e3, "µm"), ("tool axis", axis_deg, "°"))):
        off = _passed(np.concatenate([each[1 + k] for each in of_runs]), piece, many)
        share = off * (1e6 if k == 0 else 180.0 / np.pi) / tolerance
        channels.append(Channel(name, "deviation", -1 - k, share, tolerance, unit))
    return channels


def _passed(off: Floats, piece: Ints, between: bool) -> Floats:
    """Deviations (pieces,) at pieces (k,); or `between` the first and the second half of these, the extremes."""
    if not between:
        return off[piece]
    first, last = np.split(piece, 2)
    ends = np.column_stack((first, last + 1)).ravel()
    padded = np.append(off, off[-1:])
    low, high = (each.reduceat(padded, ends)[::2] for each in (np.minimum, np.maximum))
    return _in_order(low, high, off[first] > off[last])


def stretches(count: int) -> Ints:
    """(k + 1,) first set-points of the stretches of which the extremes are shown: of each set-point by itself where
    there are few."""
    return np.arange(count + 1) if count <= POINTS else np.linspace(0, count, POINTS // 2 + 1).astype(np.int64)


def _in_order(low: Floats, high: Floats, falling: npt.NDArray[np.bool_]) -> Floats:
    """(2 n,) extremes (n,) of stretches, in the order in which they come."""
    out: Floats = np.empty(2 * len(low))
    out[0::2] = np.where(falling, high, low)
    out[1::2] = np.where(falling, low, high)
    return out


class Curves:
    """All curves of set-points: tip speed and cap, then each kind of each joint over its limit.

    Takes the set-points block by block, in any order and in any thread, and keeps of each stretch the least and the
    largest value of each curve.
    """

    def __init__(self, source: SetPointSource, limits: Limits, units: list[str], toolpath: ToolPath | None) -> None:
        """Take where they are from, and the limits and units ("m", "rad" or "") of the joints."""
        self.count, self.limits = len(source), limits
        self.caps = FeedCaps(toolpath) if toolpath is not None else None
        self.channels = _named_curves(source.has_tool, limits, units, toolpath)
        self.edges = stretches(self.count)
        shape = len(self.channels), len(self.edges) - 1
        self.low, self.high = np.full(shape, np.inf), np.full(shape, -np.inf)
        self.first, self.last = np.empty(shape), np.empty(shape)
        self.top = 0.0
        """The largest cap."""
        self._cap = next((k for k, channel in enumerate(self.channels) if channel.name == CAP), None)
        self.has_tool = source.has_tool
        self._lengths: dict[int, float] = {}
        self._lock = threading.Lock()

    @classmethod
    def of(cls, source: SetPointSource, limits: Limits, units: list[str], toolpath: ToolPath | None) -> Curves:
        """Those of all set-points."""
        curves = cls(source, limits, units, toolpath)
        each_block(source, (curves.take,))
        return curves

    def take(self, block: Block) -> None:
        """Look at a block."""
        values, top = self._values(block), 0.0
        self._lengths[block.begin] = block.length
        if self._cap is not None:
            # only the cap may be none at all, which hides others of its stretch
            finite = np.isfinite(values[self._cap])
            top = float(values[self._cap, finite].max(initial=0.0))
        begins = np.searchsorted(self.edges, (block.begin, block.end - 1), side="right") - 1
        mine = slice(int(begins[0]), int(begins[1]) + 1)
        edges = self.edges[mine.start : mine.stop + 1]
        starts = np.maximum(edges[:-1], block.begin) - block.begin
        ends = np.minimum(edges[1:], block.end) - 1 - block.begin
        low, high = (each.reduceat(values, starts, axis=1) for each in (np.minimum, np.maximum))
        begun, ended = edges[:-1] >= block.begin, edges[1:] <= block.end
        with self._lock:
            self.top = max(self.top, top)
            np.minimum(self.low[:, mine], low, out=self.low[:, mine])
            np.maximum(self.high[:, mine], high, out=self.high[:, mine])
            self.first[:, mine][:, begun] = values[:, starts[begun]]
            self.last[:, mine][:, ended] = values[:, ends[ended]]

    def _values(self, block: Block) -> Floats:
        """(k, rows) of each curve at the set-points of a block."""
        points, speed, begin = block.points, np.zeros(len(block.near)), block.begin - block.first
        out = np.empty((len(self.channels), len(points)))
        if block.near.has_tool and len(speed) > 1:
            speed = _at_both_ends(block.near.tip_steps / np.diff(block.near.t))
        for row, channel in zip(out, self.channels):
            if channel.name == SPEED:
                row[:] = speed[begin : begin + len(points)] * 60e3
            elif channel.panel == "feed":
                assert self.caps is not None
                row[:] = self.caps.at(points.block) * 60e3
            else:
                column = block.columns(COLUMNS[channel.panel], block.begin, block.end)[channel.joint]
                np.divide(column, float(getattr(self.limits, channel.panel)[channel.joint]), out=row)
        return out

    @property
    def length(self) -> float | None:
        """Of the way of the tip [m]; None without a tool."""
        return sum(self._lengths[begin] for begin in sorted(self._lengths)) if self.has_tool else None

    def extremes(self) -> list[Channel]:
        """The curves with their values, without those of which there is none."""
        found = []
        for k, channel in enumerate(self.channels):
            few = self.count <= POINTS
            values = self.first[k] if few else _in_order(self.low[k], self.high[k], self.first[k] > self.last[k])
            if k != self._cap or self.top > 0.0:
                found.append(replace(channel, values=values, top=self.top if k == self._cap else 0.0))
        return found


def extremes(values: Floats, most: int = POINTS) -> Floats:
    """At most `most` values: of each stretch the least and the largest, in the order in which they come."""
    n = len(values)
    if n <= most:
        return values
    edges = np.linspace(0, n, most // 2 + 1).astype(np.int64)
    low = np.minimum.reduceat(values, edges[:-1])
    high = np.maximum.reduceat(values, edges[:-1])
    return _in_order(low, high, values[edges[:-1]] > values[np.maximum(edges[1:] - 1, edges[:-1])])


def limit_names(joints: tuple[str, ...], curves: Sequence[CurvedLimit] = ()) -> list[str]:
    """What can bind, as `Trajectory.limited_by` names it: "feed", "velocity X", ..., then what falls with the speed."""
    of_joints = [f"{kind} {joint}" for kind in (*KINDS, *MOTORS) for joint in joints]
    return ["feed", *of_joints, *(curve.name for curve in curves)]


def binding(trajectory: Trajectory, t: Floats) -> Ints:
    """(n,) at each time t [s] the number (in `limit_names`) of the limit that is used most, NOTHING where none
    binds."""
    motion = trajectory.at(t)
    limits = trajectory.limits
    shares = [np.abs(v) / getattr(limits, kind) for v, kind in zip((motion.qd, motion.qdd, motion.qddd), KINDS)]
    names = limit_names(trajectory.joints, limits.constants.curves)
    moment, state = np.stack([motion.q, motion.qd, motion.qdd, motion.qddd]), np.zeros((4, len(t)))
    state[1] = 1.0  # with the time as the parameter of the path
    own = {names.index(rows.name): rows.ratio(moment, state) for rows in limits.constants.rows if rows.name in names}
    for curve in limits.constants.curves:
        j, value = limits.joints.index(curve.joint), motion.qdd if curve.kind == "acceleration" else motion.qddd
        own[names.index(curve.name)] = np.abs(value[:, j]) / curve.at(motion.qd[:, j], value[:, j])
    ratios = np.column_stack((_feed_share(trajectory, t), *shares, *own.values()))
    number = np.append(np.arange(1 + len(KINDS) * len(limits)), list(own)).astype(np.int64)
    most = ratios.argmax(axis=1)
    found: Ints = np.where(ratios[np.arange(len(t)), most] >= BINDING, number[most], NOTHING)
    return found


def _feed_share(trajectory: Trajectory, t: Floats) -> Floats:
    """(n,) path speed over its cap, which stands for the feed and for the least time of a block."""
    share = np.zeros(len(t))
    run = trajectory.run_at(t)
    for k in np.unique(run):
        law, of_run = trajectory.laws[k], run == k
        local = t[of_run] - trajectory.starts[k]
        s, speed, *_ = law.at(np.clip(local, 0.0, law.duration))
        axis_run = trajectory.axis_path.runs[k]
        share[of_run] = np.where(
            local <= law.duration, speed / axis_run.speed_cap(np.clip(s, axis_run.s0, axis_run.s1)), 0.0
        )
    return share
