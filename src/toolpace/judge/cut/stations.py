"""Whether the stations of a plan's cut, in its file, are those of its motion, with the engagement found there anew."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.judge.cut.instants import CutJudge
from toolpace.judge.verification import Check

PLACE, TILT = 1e-5, 1e-3
"""How far a station may be from the way of the tip [m], and its axis from that of the motion."""
DIRECTION = 1e-6
"""By how much directions and shares of a motion may be off those that its stations tell."""
NEAR_ROWS = 20
"""Set-points before and behind a station whose block may be its own, where it is known to a tolerance of the tip."""
LOWERED, AHEAD = 0.4, 1000
"""Share of the least speed of a station and its neighbours down to which the profile may be lowered there, as a speed
bends or jumps between two of them; stations in which the next place is looked for first."""
STEEP = 0.02
"""Share of a motion along the axis from which it is looked at what the flat of the end cuts: with less it slides."""
IMMERSION = 0.03
"""Share of a turn by which an engagement may be off what is in material within a cell of it, as a mean over the height;
and by which the share of the end may be."""
ANGLES = 120
"""Of a turn at which the engagement of a slice is looked at."""
MOST_SLICES = 12
"""Of a station that are looked at."""
File = Mapping[str, Floats | Ints]


class Seen(NamedTuple):
    """Of a station, slice by slice and angle by angle."""

    everywhere: Bools
    """(slices, ANGLES) whether it is in material at all places within a cell."""
    anywhere: Bools
    """(slices, ANGLES) whether at any, of a stock that is larger by the margin of the promise, and by how well the tip
    is known."""


def engagement_checks(judge: CutJudge, file: File, stations: int) -> list[Check]:
    """Those of all stations by their columns, and of some by what the tool meets there."""
    found = [covered_check(judge, file)]
    if found[0].ok and len(file["station time"]):
        found.append(columns_check(judge, file))
    if len(found) > 1 and found[1].ok:
        chosen = chosen_stations(judge, file, stations)
        found += [arcs_check(judge, file, chosen), end_check(judge, file, chosen)]
    return found


def passed_stations(judge: CutJudge, file: File) -> tuple[Ints, Ints]:
    """(n,) stations at which the tool moves, and (n,) the set-points next to them."""
    row = np.clip(np.searchsorted(judge.points.t, file["station time"]), 1, len(judge.points) - 2)
    moves = np.zeros(len(judge.points), dtype=np.bool_)
    moves[judge.moving] = True
    stations = np.flatnonzero(moves[row])
    return stations, row[stations]


def chosen_stations(judge: CutJudge, file: File, count: int) -> list[tuple[int, int]]:
    """At most so many stations at which the tool moves, and the set-points next to them."""
    rng, (stations, rows) = np.random.default_rng(len(file["station time"])), passed_stations(judge, file)
    if not len(stations):
        return []
    chosen = np.unique(rng.integers(0, len(stations), count))
    return list(zip(stations[chosen].tolist(), rows[chosen].tolist()))


def passed_again(judge: CutJudge, file: File) -> File:
    """The same with the times at which a motion passes stations that are those of another, along nearly the same path.

    A station is looked for ahead of the one before it: as far as both are apart, and twice that; where a stretch
    begins, in its block.
    """
    tip, block, times = judge.tip, judge.points.block, []
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tip, axis=0), axis=1))])
    places, lines = np.asarray(file["station tip"], dtype=np.float64), file["station block"]
    begins = (file["engagement across"] == 0.0) & (file["engagement along"] == 0.0)
    row = 0
    for k, place in enumerate(places):
        step = float(np.linalg.norm(place - places[k - 1])) if k else 0.0
        end = int(np.searchsorted(way, way[row] + 2.0 * step + 2.0 * judge.room, side="right"))
        rows = np.arange(row, min(max(end, row + 2), len(tip)))
        if k == 0 or begins[k]:
            ahead = np.flatnonzero(block[row:] == lines[k]) + row
            rows = ahead if len(ahead) else rows
            near = np.linalg.norm(tip[rows] - place, axis=1) <= judge.promise.resolution
            # the first time that it comes by
            rows = rows[near][: 1 + int(np.argmin(np.append(np.diff(rows[near]) == 1, False)))] if near.any() else rows
        row = int(rows[np.linalg.norm(tip[rows] - place, axis=1).argmin()])
        low, high = max(row - 1, 0), min(row + 1, len(tip) - 1)
        along = tip[high] - tip[low]
        share = float(np.clip((place - tip[low]) @ along / max(float(along @ along), 1e-30), 0.0, 1.0))
        times.append(float(judge.points.t[low] + share * (judge.points.t[high] - judge.points.t[low])))
    return {**file, "station time": np.maximum.accumulate(times)}


def columns_check(judge: CutJudge, file: File) -> Check:
    """Whether tips, axes, blocks and operations of all stations are those of the motion when it passes them, and the
    directions those from one station to the next."""
    name, points = "stations of the cut", judge.points
    time, tip, axis = (np.asarray(file[f"station {each}"], dtype=np.float64) for each in ("time", "tip", "axis"))
    row = np.clip(np.searchsorted(points.t, time), 1, len(points) - 1)
    share = np.clip((time - points.t[row - 1]) / (points.t[row] - points.t[row - 1]), 0.0, 1.0)[:, None]
    there, lean = (each[row - 1] + share * (each[row] - each[row - 1]) for each in (judge.tip, points.axis))
    near = range(-2, 2) if judge.room == 0.0 else range(-NEAR_ROWS, NEAR_ROWS)
    beside = np.stack([points.block[np.clip(row + k, 0, len(points) - 1)] for k in near])
    operations = np.stack([judge.operation[np.clip(row + k, 0, len(points) - 1)] for k in near])
    # where a stretch begins its first station may be passed on the way out of a rapid, which no feed limits
    begins = (file["engagement across"] == 0.0) & (file["engagement along"] == 0.0)
    faults = {
        "a station is not on the way of the tip": np.linalg.norm(there - tip, axis=1) > np.where(
            begins, judge.promise.resolution, PLACE + judge.room
        ),
        "the axis of a station is not that of the motion": np.linalg.norm(lean - axis, axis=1) > TILT,
        "a station is in another block": (beside != file["station block"]).all(axis=0) & ~begins,
        "a station is in another operation": (operations != file["station operation"]).all(axis=0) & ~begins,
        "a speed of the profile is that of no station": _without_station(file, begins),
        "a direction is not that between stations": _off_direction(file, np.cumsum(judge.rapid, dtype=np.int64)[row]),
    }
    for words, wrong in faults.items():
        if wrong.any():
            k = int(np.argmax(wrong))
            return Check(name, 0.0, 0.0, "", False, float(time[k]), int(file["station block"][k]), note=words)
    return Check(name, 0.0, 0.0, "", True, note=f"{len(time)} of them are those of the motion")


def covered_check(judge: CutJudge, file: File) -> Check:
    """Whether a station is within a cell ahead of the tip wherever a tool moves at feed; no slice is lower than a cell.
    """
    times, rows, cell = file["station time"], judge.moving, judge.promise.resolution
    name = "stations along the cut"
    if (np.asarray(file["engagement slice_height"]) < cell * (1.0 - DIRECTION)).any():
        return Check(name, 0.0, 0.0, "", False, note="cells are higher than the slices of the engagement")
    ahead = np.searchsorted(times, judge.points.t[rows])
    places = np.append(file["station tip"], np.full((1, 3), np.inf), axis=0)
    way = np.linalg.norm(places[ahead] - judge.tip[rows], axis=1)
    if not len(rows):
        return Check(name, 0.0, cell, "m", True)
    k, most = int(way.argmax()), cell + PLACE + 2.0 * judge.room
    time, block = float(judge.points.t[rows[k]]), int(judge.points.block[rows[k]])
    return Check(name, float(way[k]), most, "m", bool(way[k] <= most), time, block, note="from the tip to the next")


def _off_direction(file: File, rapids: Ints) -> Bools:
    """(n,) whether the direction of the feed, or the shares across and along the axis, are not those of the way from
    the station before; the first of a stretch, behind a rapid or another operation, has none.

    rapids: (n,) set-points at rapid up to each station.
    """
    tip, axis = file["station tip"], file["station axis"]
    feed, across, along = (file[f"engagement {each}"] for each in ("feed_direction", "across", "along"))
    motion = np.diff(tip, axis=0, prepend=tip[:1])
    whole = np.linalg.norm(motion, axis=1)
    moves = whole > 0.0
    unit = motion / np.where(moves, whole, 1.0)[:, None]
    lengthwise = np.einsum("nc,nc->n", unit, axis)
    told = (across != 0.0) | (along != 0.0)
    first = (np.diff(file["station operation"], prepend=-1) != 0) | (np.diff(rapids, prepend=0) > 0)
    wrong = np.abs(along - lengthwise) + np.abs(across**2 + lengthwise**2 - 1.0) > DIRECTION
    sideways = unit - lengthwise[:, None] * axis
    wrong |= np.linalg.norm(across[:, None] * feed - sideways, axis=1) > 10.0 * DIRECTION
    wrong |= np.abs(np.linalg.norm(feed, axis=1) - 1.0) > DIRECTION
    off: Bools = np.where(told, wrong, moves & ~first)
    return off


def _without_station(file: File, begins: Bools) -> Bools:
    """(n,) true of the first station where the speeds of the profile are not, in their order, at or below that which
    the cut allows at a station, and not far below the least of its neighbours. Where a stretch begins the next
    station's holds."""
    most = np.asarray(file["station most"], dtype=np.float64)
    high = np.where(begins, np.append(most[1:], most[-1:]), most) * (1.0 + DIRECTION)
    low = np.minimum(np.minimum(most, np.append(most[1:], np.inf)), np.append(np.inf, most[:-1])) * LOWERED
    found, at = np.zeros(len(most), dtype=np.bool_), 0
    for speed in file["speed"][np.isfinite(file["speed"])].tolist() if "speed" in file else ():
        fits = np.flatnonzero((low[at : at + AHEAD] <= speed) & (speed <= high[at : at + AHEAD]))
        fits = fits if len(fits) else np.flatnonzero((low[at:] <= speed) & (speed <= high[at:]))
        if not len(fits):
            found[min(at, len(most) - 1)] = True
            break
        at += int(fits[0]) + 1
    return found


def arcs_check(judge: CutJudge, file: File, chosen: list[tuple[int, int]]) -> Check:
    """Whether the arcs of some stations are in material: in each slice the angles that are told, or not, without being
    in material anywhere, or everywhere, within a cell of it."""
    what = "engagement of the cut"
    worst = Check(what, 0.0, IMMERSION, "", True)
    first = np.concatenate([[0], np.cumsum(file["engagement arcs"])]).astype(np.int64)
    for i, row in chosen:
        arcs, high = slice(first[i], first[i + 1]), float(file["engagement slice_height"][i])
        told = told_at(*(file[f"engagement {each}"][arcs] for each in ("slice", "entry", "exit")))
        slices = slices_of(judge, row, high, len(told))
        said = np.zeros((len(slices), ANGLES), dtype=np.bool_)
        known = slices < len(told)
        said[known] = told[slices[known]]
        off = math.inf
        for rows in ([row], judge.rows_near(row, judge.promise.resolution)):
            seen = seen_within(judge, rows, high, slices, file["engagement feed_direction"][i])
            off = float(((said & ~seen.anywhere) | (~said & seen.everywhere)).mean())
            if off <= IMMERSION:
                break
        if off > worst.value:
            time, block = float(judge.points.t[row]), int(judge.points.block[row])
            worst = Check(what, off, IMMERSION, "", off <= IMMERSION, time, block, note="share of a turn")
    return worst


def told_at(slices: Floats | Ints, entry: Floats | Ints, leave: Floats | Ints) -> Bools:
    """(slices, ANGLES) which angles are told to be in material."""
    found = np.zeros((int(slices.max(initial=-1)) + 1, ANGLES), dtype=np.bool_)
    angle = (np.arange(ANGLES) + 0.5) * 2.0 * math.pi / ANGLES
    for j, begin, end in zip(slices.tolist(), entry.tolist(), leave.tolist()):
        found[j] |= (angle - begin) % (2.0 * math.pi) <= end - begin
    return found


def slices_of(judge: CutJudge, row: int, high: float, told: int) -> Ints:
    """Which slices of a height [m] of a station are looked at: up to the last that is told or in material."""
    surface = judge.surface(row)
    _, top, _ = surface.shape.at(np.array([surface.top()]))
    count = max(told, math.ceil(float(top[0]) / high), 1)
    return np.unique(np.linspace(0, count - 1, min(count, MOST_SLICES)).round().astype(np.int64))


def seen_within(judge: CutJudge, rows: list[int], high: float, slices: Ints, feed: Floats | Ints) -> Seen:
    """What is in material of slices (m,) of a height [m] at set-points next to each other, from half a slice below each
    to half of one above; angles are from a direction of the feed (3,)."""
    everywhere = np.ones((len(slices), ANGLES), dtype=np.bool_)
    anywhere = ~everywhere
    for row in rows:
        surface = judge.surface(row)
        begin = surface.motion.angle_of_feed(np.asarray(feed, dtype=np.float64))
        for share in (0.02, 0.5, 0.98):
            height = np.minimum((slices + share) * high, surface.shape.reach * (1.0 - 1e-9))
            lengths = surface.shape.length_at(height)
            everywhere &= surface.seen_at(lengths, ANGLES, first=begin)
            anywhere |= surface.seen_at(lengths, ANGLES, judge.promise.margin + judge.room, begin, judge.room)
    return Seen(everywhere, anywhere)


def end_check(judge: CutJudge, file: File, chosen: list[tuple[int, int]]) -> Check:
    """Whether the share of the flat end that cuts is that which the file tells, where the motion goes down."""
    worst = Check("end of the tool in the cut", 0.0, IMMERSION, "", True)
    for i, row in chosen:
        if float(file["engagement along"][i]) > -STEEP:
            continue
        told, shares = float(file["engagement bottom"][i]), []
        for each in judge.rows_near(row, judge.promise.resolution):
            shares.append(share_of_end(judge, each))
            off = max(min(shares) - told, told - max(shares), 0.0)
            if off <= IMMERSION:
                break
        # at the border of what is cut a cell is in or out
        off -= judge.promise.resolution / max(math.pi * judge.surface(row).shape.flat, judge.promise.resolution)
        if off > worst.value:
            time, block = float(judge.points.t[row]), int(judge.points.block[row])
            worst = Check(worst.what, off, IMMERSION, "", off <= IMMERSION, time, block, note="share of its area")
    return worst


def share_of_end(judge: CutJudge, row: int) -> float:
    """The share of the flat of the tool's end that moves into material."""
    surface = judge.surface(row)
    flat = surface.shape.flat
    if flat <= 0.0:
        return 0.0
    radius = flat * (np.arange(8) + 0.5) / 8
    seen = surface.seen_at(radius, ANGLES)
    return float((seen.mean(axis=1) * radius).sum() / radius.sum())
