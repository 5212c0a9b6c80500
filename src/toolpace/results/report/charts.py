"""Data of the report's charts: curves over time with their peaks kept, the limit that binds, the tip's way in space."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.machine.limits import KINDS, Limits
from toolpace.motion.setpoints import SetPoints
from toolpace.motion.trajectory import Trajectory
from toolpace.programs.toolpath import ToolPath

POINTS = 40_000
"""Points of each channel in the file, and line numbers: twenty for each pixel of a wide screen."""
_FULL = 32_000
"""The largest value of a curve as a 16-bit integer, of 32 767: the step between two is below what a screen shows."""
_MISSING = -32_768
"""Stands where there is no value."""
BINDING = 0.99
"""Share of a limit from which it is shown as binding."""
NOTHING = -1
"""Stands where nothing binds, in place of the number of a limit."""
STATIONS = 24_000
"""Points of the tip's way: a browser turns so many in space without a jerk, and chords of them look like the curve."""
WHISKERS = 500
"""Tool axes drawn: more would hide the way of the tip."""


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
    of_runs = [each for each in found if each is not None]
    if len(of_runs) < len(found) or tip_mm is None or axis_deg is None:
        return []
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
        off = np.concatenate([each[1 + k] for each in of_runs])[piece]
        share = off * (1e6 if k == 0 else 180.0 / np.pi) / tolerance
        channels.append(Channel(name, "deviation", -1 - k, share, tolerance, unit))
    return channels


def extremes(values: Floats, most: int = POINTS) -> Floats:
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


def blocks_over_time(setpoints: SetPoints, most: int = POINTS) -> dict[str, object]:
    """Line numbers over time, for the texts that a pointer calls up."""
    at = np.linspace(0, len(setpoints) - 1, min(len(setpoints), most)).astype(np.int64)
    return {"data": encoded(setpoints.block[at].astype("<i4"))}


def limit_names(joints: tuple[str, ...]) -> list[str]:
    """What can bind, as `Trajectory.limited_by` names it: "feed", "velocity X", ..."""
    return ["feed", *(f"{kind} {joint}" for kind in KINDS for joint in joints)]


def binding(trajectory: Trajectory, t: Floats) -> Ints:
    """(n,) at each time t [s] the number (in `limit_names`) of the limit that is used most, NOTHING where none
    binds."""
    motion = trajectory.at(t)
    limits = trajectory.limits
    shares = [np.abs(v) / getattr(limits, kind) for v, kind in zip((motion.qd, motion.qdd, motion.qddd), KINDS)]
    ratios = np.column_stack((_feed_share(trajectory, t), *shares))
    most = ratios.argmax(axis=1)
    found: Ints = np.where(ratios[np.arange(len(t)), most] >= BINDING, most, NOTHING)
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


def stations(setpoints: SetPoints, most: int = STATIONS) -> Ints:
    """Set-points to draw: as many in equal steps of time as in equal steps of length, so that neither slow
    corners nor fast moves turn into polygons."""
    n = len(setpoints)
    if n <= most:
        return np.arange(n)
    length = np.concatenate(([0.0], np.cumsum(setpoints.tip_steps)))
    measure = np.arange(n) / (n - 1) + length / max(float(length[-1]), 1e-30)
    at = np.searchsorted(measure, np.linspace(0.0, measure[-1], most))
    found: Ints = np.unique(np.clip(at, 0, n - 1))
    return found


def scene_data(setpoints: SetPoints, at: Ints, limiting: Ints, cap: Floats | None) -> dict[str, object]:
    """Data of the picture: tip [mm], speed [mm/min], what binds, block, and the whiskers, at the set-points
    `at`."""
    tip = setpoints.tip[at] * 1e3
    speed = tip_speed(setpoints)[at] * 60e3
    # Rapids would take the whole range of colours; it belongs to the cut.
    cutting = np.isfinite(cap[at]) if cap is not None else np.ones(len(at), dtype=bool)
    top = float(speed[cutting].max()) if cutting.any() else float(speed.max())
    size = float(np.sqrt(((tip.max(axis=0) - tip.min(axis=0)) ** 2).sum()))
    moved = np.concatenate(([0.0], np.cumsum(np.sqrt(((tip[1:] - tip[:-1]) ** 2).sum(axis=1)))))
    turned = np.concatenate(([0.0], np.cumsum(np.sqrt((np.diff(setpoints.axis[at], axis=0) ** 2).sum(axis=1)))))
    measure = moved / max(moved[-1], 1e-12) + 0.5 * turned / max(turned[-1], 1e-12)
    some = np.unique(np.clip(np.searchsorted(measure, np.linspace(0.0, measure[-1], WHISKERS)), 0, len(at) - 1))
    whiskers = np.full((len(some), 3, 3), np.nan)
    whiskers[:, 0] = tip[some]
    whiskers[:, 1] = tip[some] + setpoints.axis[at[some]] * max(0.07 * size, 1.0)
    return {
        "x": encoded(tip[:, 0].astype("<f4")),
        "y": encoded(tip[:, 1].astype("<f4")),
        "z": encoded(tip[:, 2].astype("<f4")),
        "speed": encoded(speed.astype("<f4")),
        "top": max(top, 1e-9),
        "limiting": encoded(limiting.astype("<i2")),
        "block": encoded(setpoints.block[at].astype("<i4")),
        "t": encoded(setpoints.t[at].astype("<f4")),
        "whiskers": [encoded(whiskers[:, :, k].ravel().astype("<f4")) for k in range(3)],
    }
