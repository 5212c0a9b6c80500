"""The cut of set-points, judged: what was promised of its loads, held against a tool that is turned through in time,
and the engagement that a plan tells of it, held against sections at stations of the judge's own choice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.cut.instants import CutJudge, CutPromise, Instant
from toolpace.judge.cut.stations import chosen_stations, engagement_checks
from toolpace.judge.verification import Check
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

__all__ = ["CutJudge", "CutPromise", "Instant", "checks_of_cut", "cut_checks", "not_judged"]

INSTANTS, STATIONS = 24, 12
"""That are judged."""
HELD = 0.01
"""Share of a limit by which a load may pass it: what the cells of the accused stock do to an engagement."""
LEARNED = 0.03
"""Share by which a load may pass that of its teacher: cells tell both to about a hundredth."""
SPEED = 1e-4
"""Share of a speed by which set-points may pass it, as all limits."""
THIN = 0.05
"""Share of a cell: what is cut thinner on the mean counts as air."""
UNITS = {
    "chip": "m", "feed_per_tooth": "m", "removal_rate": "m3/s", "force": "N", "torque": "N m", "power": "W",
    "moment": "N m", "stress": "Pa", "deflection": "m", "surface_deflection": "m", "compensated_deflection": "m",
    "feed_marks": "m",
}  # fmt: skip
CutFile = Mapping[str, Floats | Ints]
"""The arrays of cut_limits.npz."""


def checks_of_cut(points: SetPoints, toolpath: ToolPath, promise: CutPromise, file: CutFile) -> list[Check]:
    """Whether the cut of set-points along a tool path with the program's own feeds is as was promised, and whether a
    plan's file tells it as it is."""
    judge = CutJudge(points, toolpath, promise)
    checks = cut_checks(judge, file, INSTANTS, STATIONS)
    if judge.unseen:
        checks.append(not_judged(f"no shape is known of tool {', '.join(judge.unseen)}"))
    return checks


def not_judged(reason: str) -> Check:
    """That the cut, or a part of it, was not looked at: no failure, and no success."""
    return Check("cut", math.nan, 0.0, "", True, note=reason, judged=False)


def cut_checks(judge: CutJudge, file: CutFile, instants: int, stations: int) -> list[Check]:
    """Those at so many instants and stations of the judge's choice."""
    promise, raised = judge.promise, judge.moving[judge.speed[judge.moving] > (1.0 + SPEED) * judge.feed[judge.moving]]
    if promise.stock is None:
        return [raised_check(judge, raised), not_judged("the stock is a guess")]
    checks = engagement_checks(judge, file, stations)
    if promise.feeds == "limits":
        checks += limit_checks(judge, judge.instants(instants))
    if promise.feeds == "air":
        checks.append(air_check(judge, judge.instants(instants, rows=raised)))
    if promise.feeds == "learned":
        checks.append(learned_check(judge, judge.instants(instants, rows=raised)))
    return [*checks, allowed_check(judge, file, stations), speed_check(judge, file)]


def raised_check(judge: CutJudge, raised: Ints) -> Check:
    """Whether the tip is nowhere faster than the program's feed."""
    if not len(raised):
        return Check("feed of the program", 0.0, 0.0, "", True, note="is not raised on a guess")
    row = int(raised[np.argmax(judge.speed[raised] / np.maximum(judge.feed[raised], 1e-12))])
    speed, feed = float(judge.speed[row]), float(judge.feed[row])
    time, block = float(judge.points.t[row]), int(judge.points.block[row])
    return Check("feed of the program", speed, feed, "m/s", False, time, block, note="raised on a guess")


def limit_checks(judge: CutJudge, found: Sequence[Instant]) -> list[Check]:
    """The worst instant of each limit, of all tools."""
    by_name: dict[str, list[Instant]] = {}
    for each in found:
        for name in judge.promise.limits_of(each.tool):
            by_name.setdefault(name, []).append(each)
    return [limit_check(judge, instants, name) for name, instants in by_name.items()]


def limit_check(judge: CutJudge, found: Sequence[Instant], name: str) -> Check:
    """Whether a limit is held at instants of tools that have it."""

    def share_of(at: Instant) -> float:
        return float(at.loads.get(name, 0.0)) / judge.promise.limits_of(at.tool)[name]

    worst, share = worst_of(judge, found, share_of, 1.0 + HELD)
    limit, what = judge.promise.limits_of(worst.tool)[name], f"{name.replace('_', ' ')} of the cut"
    return Check(what, share * limit, limit, UNITS[name], share <= 1.0 + HELD, worst.time, worst.block)


def air_check(judge: CutJudge, found: Sequence[Instant]) -> Check:
    """Whether nothing is cut where the tip is faster than the program's feed; a layer below THIN of a cell is
    nothing."""
    what, limit = "cut above the feed", THIN * judge.promise.resolution
    if not found:
        return Check(what, 0.0, limit, "m", True)
    worst, layer = worst_of(judge, found, layer_above_feed, limit)
    return Check(what, layer, limit, "m", layer <= limit, worst.time, worst.block, note="layer on the mean")


def learned_check(judge: CutJudge, found: Sequence[Instant]) -> Check:
    """Whether chip, area and edge are all within those of one teacher, wherever the tip is faster than the program's
    feed."""
    what, limit = "load over its teacher's", 1.0 + LEARNED
    if not found:
        return Check(what, 0.0, limit, "", True)
    worst, share = worst_of(judge, found, lambda at: share_of_teacher(judge.promise, at), limit)
    return Check(what, share, limit, "", share <= limit, worst.time, worst.block)


def allowed_check(judge: CutJudge, file: CutFile, stations: int) -> Check:
    """Whether what was promised would hold at some stations, were the tip as fast as the file says that it may be."""
    promise, worst = judge.promise, Check("cut at the speed that is allowed", 0.0, 1.0, "", True)

    def share_of(at: Instant) -> float:
        if promise.feeds == "air":
            return layer_above_feed(at) / (THIN * promise.resolution)
        if promise.feeds == "learned":
            return share_of_teacher(promise, at) / (1.0 + LEARNED)
        limits = promise.limits_of(at.tool)
        return max((float(at.loads.get(name, 0.0)) / limits[name] for name in limits), default=0.0) / (1.0 + HELD)

    for i, row in chosen_stations(judge, file, stations):
        speed = float(file["station most"][i])
        if speed > 0.0:
            at = judge.instant(row, speed)
            share = share_of(at)
            if share > 1.0:
                near = judge.rows_near(row, promise.resolution)
                share = min(share_of(judge.instant(each, speed)) for each in near)
            if share > worst.value:
                worst = Check(worst.what, share, 1.0, "", share <= 1.0, at.time, at.block, note="share of its load")
    return worst


def worst_of(
    judge: CutJudge, found: Sequence[Instant], value_of: Callable[[Instant], float], most: float
) -> tuple[Instant, float]:
    """The instant with the largest value, and that value. Above the most that may be, the least at places within a cell
    counts: where a cut begins and ends is known to a cell, and there alone a plan may be wrong about it."""
    worst, largest = found[0], -math.inf
    for each in sorted(found, key=value_of, reverse=True):
        value = value_of(each)
        if value > most:
            near = judge.rows_near(each.row, judge.promise.resolution)
            value = min(value_of(judge.instant(row)) for row in near)
        if value > largest:
            worst, largest = each, value
        if largest > most or value_of(each) <= most:
            break
    return worst, largest


def layer_above_feed(at: Instant) -> float:
    """What is cut on the mean over the height [m], where the tip is faster than the program's feed."""
    return at.loads["layer"] if at.speed > (1.0 + SPEED) * at.feed else 0.0


def share_of_teacher(promise: CutPromise, at: Instant) -> float:
    """The largest of chip, area and edge over those of the teacher that allows most, where the tip is faster than the
    program's feed."""
    if at.speed <= (1.0 + SPEED) * at.feed or at.loads["chip"] <= 0.0:
        return 0.0
    own = np.array([at.loads[name] for name in ("chip", "area", "edge")])
    teachers = np.array(promise.teachers.get(at.tool, ())).reshape(-1, 3)
    return float((own / teachers).max(axis=1).min(initial=math.inf))


def speed_check(judge: CutJudge, file: CutFile) -> Check:
    """Whether the tip is at any set-point faster than a file says that its cut allows at the stations beside it."""
    times, most = file["station time"], file["station most"]
    rows, worst = judge.moving, Check("speed by the cut", 0.0, math.inf, "m/s", True)
    at = np.searchsorted(times, judge.points.t[rows])
    beside = (at > 0) & (at < len(times))
    rows, at = rows[beside], at[beside]
    if not len(rows):
        return worst
    allowed = np.maximum.reduce([most[np.clip(at + k, 0, len(most) - 1)] for k in (-1, 0, 1)])
    speed = judge.speed[rows]
    k = int(np.argmax(speed / np.maximum(allowed, 1e-12)))
    ok = bool(speed[k] <= (1.0 + SPEED) * allowed[k])
    time, block = float(judge.points.t[rows[k]]), int(judge.points.block[rows[k]])
    return Check(worst.what, float(speed[k]), float(allowed[k]), "m/s", ok, time, block)
