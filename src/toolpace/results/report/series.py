"""The curves of the report as small integers over time, with peaks kept."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath

MOST = 40_000
"""Points of each channel in the file; a browser thins them again to what its screen can show."""
_FULL = 32_000
"""The largest value of a curve as a 16-bit integer, of 32 767: the step between two is below what a screen shows."""
_MISSING = -32_768
"""Stands where there is no value."""
BLOCKS = 40_000
"""Line numbers over time that a page holds: twenty for each pixel of a wide screen."""


@dataclass(frozen=True)
class Channel:
    """One curve: what it is, and its values at the set-points."""

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


def encoded(values: npt.NDArray[np.generic]) -> str:
    """Raw little-endian bytes as text."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def tip_speed(setpoints: SetPoints) -> Floats:
    """(n,) speed of the tip [m/s] by differences over one step each way."""
    if not setpoints.has_tool or len(setpoints) < 2:
        return np.zeros(0)
    step = setpoints.tip_steps / np.diff(setpoints.t)
    speed: Floats = np.concatenate((step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]))
    return speed


def feed_cap(setpoints: SetPoints, toolpath: ToolPath) -> Floats:
    """(n,) the feed that the program asks for in the block of each set-point [m/s]; inf where it asks for
    none."""
    way = toolpath.way_length
    timed = (toolpath.least_time > 0.0) & (way > 0.0)
    cap = np.where(timed, np.minimum(toolpath.feed, way / np.where(timed, toolpath.least_time, 1.0)), toolpath.feed)
    blocks, where = np.unique(toolpath.block[1:], return_inverse=True)
    if not len(blocks):
        return np.full(len(setpoints), np.inf)
    most = np.zeros(len(blocks))
    np.maximum.at(most, where, cap[1:])
    at = np.clip(np.searchsorted(blocks, setpoints.block), 0, len(blocks) - 1)
    found: Floats = np.where(blocks[at] == setpoints.block, most[at], np.inf)
    return found


def channels(setpoints: SetPoints, limits: Limits, units: list[str], toolpath: ToolPath | None) -> list[Channel]:
    """All curves: tip speed and cap, then each kind of each joint over its limit."""
    found = []
    if setpoints.has_tool:
        found.append(Channel("tip speed", "feed", -1, tip_speed(setpoints) * 60e3, 1.0, "mm/min"))
        if toolpath is not None:
            cap = feed_cap(setpoints, toolpath) * 60e3
            if np.isfinite(cap).any():
                found.append(Channel("feed in the program", "feed", -1, cap, 1.0, "mm/min"))
    per = {"velocity": "/s", "acceleration": "/s²", "jerk": "/s³"}
    for kind, values in zip(KINDS, (setpoints.qd, setpoints.qdd, setpoints.qddd)):
        for j, joint in enumerate(setpoints.joints):
            limit = float(getattr(limits, kind)[j])
            if np.isfinite(limit):
                scale = {"m": 1e3, "rad": 180.0 / np.pi}.get(units[j], 1.0)
                unit = {"m": "mm", "rad": "°"}.get(units[j], "") + per[kind]
                found.append(Channel(joint, kind, j, values[:, j] / limit, limit * scale, unit))
    return found


def deviations(trajectory: Trajectory, t: Floats, tip_mm: float | None, axis_deg: float | None) -> list[Channel]:
    """Curves of how far the path is off the program at times t (n,), as shares of the tolerances [mm], [deg]; none
    where that is not known. The largest that was found in the piece of the path that is passed."""
    found = [run.deviations() for run in trajectory.axis_path.runs]
    known = [each for each in found if each is not None]
    if len(known) < len(found) or tip_mm is None or axis_deg is None:
        return []
    s, run = trajectory.parameter(t), trajectory.run_at(t)
    piece = np.zeros(len(t), dtype=np.int64)
    pieces = 0
    for k, (breaks, *_) in enumerate(known):
        of_run = run == k
        last = len(breaks) - 2
        piece[of_run] = pieces + np.clip(np.searchsorted(breaks, s[of_run], side="right") - 1, 0, last)
        pieces += last + 1
    channels = []
    for k, (name, tolerance, unit) in enumerate((("tip", tip_mm * 1e3, "µm"), ("tool axis", axis_deg, "°"))):
        off = np.concatenate([each[1 + k] for each in known])[piece]
        share = off * (1e6 if k == 0 else 180.0 / np.pi) / tolerance
        channels.append(Channel(name, "deviation", -1 - k, share, tolerance, unit))
    return channels


def extremes(values: Floats, most: int = MOST) -> Floats:
    """At most `most` values: of each stretch the least and the largest, in the order in which they come."""
    n = len(values)
    if n <= most:
        return values
    edges = np.linspace(0, n, most // 2 + 1).astype(np.int64)
    low = np.minimum.reduceat(values, edges[:-1])
    high = np.maximum.reduceat(values, edges[:-1])
    falling = values[edges[:-1]] > values[np.maximum(edges[1:] - 1, edges[:-1])]
    out: Floats = np.empty(2 * len(low))
    out[0::2] = np.where(falling, high, low)
    out[1::2] = np.where(falling, low, high)
    return out


def packed(channel: Channel) -> dict[str, object]:
    """A channel for the page: 16-bit integers times a scale; a gap where there is no value."""
    values = channel.values
    finite = np.isfinite(values)
    top = float(np.abs(values[finite]).max()) if finite.any() else 1.0
    scale = max(top, 1e-12) / _FULL
    small = extremes(np.where(finite, values / scale, np.inf))
    whole = np.where(np.isfinite(small), np.round(np.where(np.isfinite(small), small, 0.0)), _MISSING)
    return {
        "name": channel.name,
        "panel": channel.panel,
        "joint": channel.joint,
        "scale": scale,
        "peak": channel.peak,
        "unit": channel.unit,
        "top": top,
        "data": encoded(whole.astype("<i2")),
    }


def blocks_over_time(setpoints: SetPoints, most: int = BLOCKS) -> dict[str, object]:
    """Line numbers over time, for the texts that a pointer calls up."""
    at = np.linspace(0, len(setpoints) - 1, min(len(setpoints), most)).astype(np.int64)
    return {"data": encoded(setpoints.block[at].astype("<i4"))}
