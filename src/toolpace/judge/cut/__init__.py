"""The cut of set-points, judged: what was promised of its loads, held against a tool that is turned through in time,
and the engagement that a plan tells of it, held against sections at stations of the judge's own choice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.judge.alignment import Lost
from toolpace.judge.cut.instants import CutJudge, CutPromise, Instant
from toolpace.judge.cut.stations import chosen_stations, engagement_checks, passed_again, passed_stations
from toolpace.judge.program import JudgedProgram
from toolpace.judge.tool import forward_kinematics
from toolpace.judge.verification import Check
from toolpace.machine.cutting_tool import CuttingTool
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

__all__ = ["Bent", "CutJudge", "CutPromise", "Instant", "checks_of_cut", "cut_checks", "not_judged"]

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
STAYING = 5
"""Points of a tool that may be beside what stays: cells do not tell less of it."""
STEADY, REACHED = 5, 0.97
"""Places at which it is looked whether a limit that sets the speed is reached, and the share that must be: cells may
tell an engagement too high."""
UNITS = {
    "chip": "m", "feed_per_tooth": "m", "removal_rate": "m3/s", "force": "N", "torque": "N m", "power": "W",
    "moment": "N m", "stress": "Pa", "deflection": "m", "surface_deflection": "m", "compensated_deflection": "m",
    "feed_marks": "m",
}  # fmt: skip
CutFile = Mapping[str, Floats | Ints]
"""The arrays of cut_limits.npz."""


def checks_of_cut(
    points: SetPoints, toolpath: ToolPath, promise: CutPromise, file: CutFile, bent: Bent | None = None
) -> list[Check]:
    """Whether the cut of set-points along a tool path with the program's own feeds is as was promised, and whether a
    plan's file tells it as it is; bent: of a tool that bends, on a path that is compensated for it."""
    if bent is None:
        judge = CutJudge(points, toolpath, promise)
    else:
        tips = bent.tips(points)
        if tips is None:
            return [not_judged("the motion is not that of the program")]
        judge = CutJudge(points, toolpath, promise, tips, bent.room)
        file = passed_again(judge, file)
    checks = cut_checks(judge, file, INSTANTS, STATIONS)
    if judge.unseen:
        checks.append(not_judged(f"no shape is known of tool {', '.join(judge.unseen)}"))
    return checks


@dataclass(frozen=True)
class Bent:
    """A tool that bends, on a machine, along a program with the feeds that its cut allows."""

    tool: CuttingTool
    machine: Machine
    toolpath: ToolPath
    tip: Tolerances
    axis: Tolerances

    @property
    def room(self) -> float:
        """How far the bent tip may be from a path within the tolerance [m]: both may be off to either side."""
        return 2.0 * float(self.tip.tip_beside_chords(self.toolpath).max())

    def tips(self, points: SetPoints) -> Floats | None:
        """(n, 3) of the bent tool at set-points [m]; None where they are not this program's."""
        program = JudgedProgram(self.toolpath, self.machine, self.tip, self.axis, self.tool)
        assert program.bent is not None
        there, dt = forward_kinematics(points, self.machine), float(points.t[1] - points.t[0])
        tips = program.bent.tips(points, *there, program.line.poses, program.owner, program.along, dt)
        return None if isinstance(tips, Lost) else tips


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
    if not promise.finishing:
        checks.append(finishing_check(judge, raised))
    return [*checks, allowed_check(judge, file, stations), *reached_checks(judge, file), speed_check(judge, file)]


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
        for name in each.limits:
            by_name.setdefault(name, []).append(each)
    return [limit_check(judge, instants, name) for name, instants in by_name.items()]


def limit_check(judge: CutJudge, found: Sequence[Instant], name: str) -> Check:
    """Whether a limit is held at instants of tools that have it."""

    def share_of(at: Instant) -> float:
        return float(at.loads.get(name, 0.0)) / at.limits[name]

    worst, share = worst_of(judge, found, share_of, 1.0 + HELD)
    limit, what = worst.limits[name], f"{name.replace('_', ' ')} of the cut"
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


def finishing_check(judge: CutJudge, raised: Ints) -> Check:
    """Whether nowhere a surface that stays is beside the tool where the tip is faster than the program's feed."""
    worst = Check("surface that stays, above the feed", 0.0, STAYING, "", True, note="points of the tool beside it")
    chosen = np.random.default_rng(len(raised)).permutation(raised)[:STATIONS]
    for row in np.sort(chosen).tolist():
        count = judge.staying(row)
        if count > STAYING:
            count = min(judge.staying(each) for each in judge.rows_near(row, judge.promise.resolution))
        if count > worst.value:
            time, block = float(judge.points.t[row]), int(judge.points.block[row])
            worst = Check(worst.what, count, STAYING, "", count <= STAYING, time, block, note=worst.note)
        if not worst.ok:
            break
    return worst


def allowed_check(judge: CutJudge, file: CutFile, stations: int) -> Check:
    """Whether what was promised would hold at some stations, were the tip as fast as the file says that it may be."""
    promise, worst = judge.promise, Check("cut at the speed that is allowed", 0.0, 1.0, "", True)

    def share_of(at: Instant) -> float:
        if promise.feeds == "air":
            return layer_above_feed(at) / (THIN * promise.resolution)
        if promise.feeds == "learned":
            return share_of_teacher(promise, at) / (1.0 + LEARNED)
        shares = (float(at.loads.get(name, 0.0)) / limit for name, limit in at.limits.items())
        return max(shares, default=0.0) / (1.0 + HELD)

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


def reached_checks(judge: CutJudge, file: CutFile) -> list[Check]:
    """Whether each limit that sets speeds, as the file has it, is promised, and reached at the speeds that it allows:
    where another limit, material, spindle or tool is told than that which the plan was made with, it is not."""
    promise, most = judge.promise, np.asarray(file["station most"], dtype=np.float64)
    if promise.feeds == "air":
        return []
    stations, rows = passed_stations(judge, file)
    held = (most[stations] > 0.0) & ((promise.feeds == "limits") | (most[stations] > (1.0 + SPEED) * judge.feed[rows]))
    stations, rows = stations[held], rows[held]
    beside = np.abs(np.append(most[1:], most[-1:]) - np.append(most[:1], most[:-1]))
    changes, rng = beside[stations] / most[stations], np.random.default_rng(len(most))
    source, found = np.asarray(file["station limit"], dtype=np.int64)[stations], []
    for index in np.unique(source).tolist():
        name, some = str(file["names"][index]), np.flatnonzero(source == index)
        if name not in ("feed", "feed in air"):
            # where a speed changes it is that of a place beside
            steady = some[np.argsort(changes[some], kind="stable")][: math.ceil(len(some) / 4)]
            chosen = np.sort(rng.permutation(steady)[:STEADY])
            at = [judge.instant(int(rows[k]), float(most[stations[k]])) for k in chosen.tolist()]
            found.append(reached_check(promise, at, name))
    return found


def reached_check(promise: CutPromise, at: Sequence[Instant], name: str) -> Check:
    """Whether what sets the speeds of some places is reached at one of them."""
    what, kind = f"{name}, where it sets the speed", name.replace(" ", "_")
    if promise.feeds == "learned":
        shares = [share_of_teacher(promise, each) if name == "load of the teacher" else math.nan for each in at]
    else:
        shares = [float(each.loads.get(kind, 0.0)) / each.limits.get(kind, math.nan) for each in at]
    k = int(np.argmax(shares))
    if math.isnan(shares[k]):
        return Check(what, math.nan, 0.0, "", False, at[k].time, at[k].block, note="is none that was promised")
    note = "share of it"
    return Check(what, shares[k], REACHED, "", shares[k] >= REACHED, at[k].time, at[k].block, note=note, at_least=True)


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
