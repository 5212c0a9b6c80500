"""Checks of plan.json against set-points, machine and program; and of setpoints.csv against the set-points.

What only the planner can know is held against what else is said; it is listed in AS_SAID, and nothing else is believed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError, printable
from toolpace.common.files import reason
from toolpace.common.units import DEGREE, MILLIMETRE, parse_angle, parse_length
from toolpace.judge.feed_check import FeedUse
from toolpace.judge.passage_times import OperationFigures, Passages
from toolpace.judge.tool import way_lengths
from toolpace.judge.usage import UsageFigures, wrong
from toolpace.judge.verification import Check, Verification
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.tolerances import Tolerances
from toolpace.programs.toolpath import ToolPath

SAME = 1e-9
"""Relative difference of figures that are worked out in the same way twice; of the begins of two places [s]."""
EARLY = 20
"""Set-points by which the begin of a place where time could be gained may lie in the block before or behind."""
SAME_BENDING = 2e-6
"""Difference of the most that a tool bends, worked out in two ways [m]."""
MOST_CHANGE, MOST_ROUNDS = 1.0, 100
"""Of bending that converged [um], and rounds that it took."""
CUT_TIME, CUT_VOLUME = 1e-3, 1e-3
"""Of a cut: by how much its times may exceed the time at feed [s]; share of the stock that may go amiss."""
EFFORTS = ("low", "normal", "high")
DEFAULT_TIP_MM, DEFAULT_AXIS_DEG = 0.01, 0.05
"""Tolerances that are taken where none are given; wider ones are pointed out."""

RECOMPUTED = (
    "duration_s", "gap", "blocks", "stops", "usage", "limited_by", "tip_deviation_mm", "axis_deviation_deg", "machine",
    "dt_s", "set_points", "path_length_mm", "verified", "program_file", "lower_bound_of", "controller", "assumed",
    "skipped", "operations", "cutting_s", "rapid_s", "dwell_s", "bending", "cut_limits",
)  # fmt: skip
IN_THE_VERDICT = (
    "tip_tolerance_mm", "axis_tolerance_deg", "tip_tolerances", "axis_tolerances", "feed", "dialect", "reading",
)  # fmt: skip
"""What was asked for: judged by, and said with the verdict."""
AS_SAID = (
    "lower_bound_s", "continuous_bound_s", "open_places", "mesh_points", "solve_s", "fit_s", "step_s", "planner",
    "program", "toolpace_version", "effort", "rounds", "tip_at_tolerance", "axis_at_tolerance", "prices_s",
    "cut",
)  # fmt: skip
"""What only the planner knows: held against the other figures."""
ROUNDING = 2e-14
"""Of setpoints.csv: relative rounding of fifteen digits, and of the change of units."""
CHUNK = 50_000
"""Rows of setpoints.csv that are read at once, to keep memory low."""
COLUMNS = (("", "q", ""), (" velocity", "qd", "/s"), (" acceleration", "qdd", "/s2"), (" jerk", "qddd", "/s3"))
"""Of setpoints.csv: what its headings add to a joint's name and unit, and the field of `SetPoints` for each."""


def told_tolerances(text: str, *, tip: bool) -> Tolerances:
    """Tolerances by place, from their text in plan.json. Raises UsageError."""
    usual = DEFAULT_TIP_MM * MILLIMETRE if tip else DEFAULT_AXIS_DEG * DEGREE
    return Tolerances.parse(text, parse_length if tip else parse_angle, usual)


@dataclass(frozen=True)
class Figures:
    """The figures of a plan, and what they are judged by."""

    said: Mapping[str, Any]
    """plan.json, key by key."""
    points: SetPoints
    machine: Machine
    toolpath: ToolPath | None
    verification: Verification
    """What the set-points came to."""
    feed_use: FeedUse | None
    """Of the tip; None where the program has no feeds, or was not judged."""
    passages: Passages | None = None
    """When the motion passes the points of the program; None where it is not its, or was not judged."""

    def checks(self) -> list[Check]:
        """One check a figure, or a group of them."""
        dt = self.verification.dt
        usage = UsageFigures(self.said, self.points, self.machine, self.toolpath, self.feed_use, dt)
        found = self.of_time() + self.of_bounds() + self.of_counts() + usage.of_usage() + self.of_names()
        found += self.of_reading() + self.of_bending() + self.of_rounds()
        found += self.of_tolerances() + self.of_cut()
        return found + self.of_deviations() + usage.of_shares() + usage.of_prices() + self.of_places()

    def same(self, key: str, right: float, unit: str = "", share: float = SAME) -> Check:
        """A figure that must be what is found."""
        said = float(self.said[key])
        ok = abs(said - right) <= share * max(abs(right), 1e-12)
        return Check(f"plan.json {key}", said, right, unit, ok, note=f"found: {right:.10g}")

    def of_tolerances(self) -> list[Check]:
        """The widest of tolerances that differ from place to place."""
        if self.toolpath is None:
            return []
        tip, axis, checks = self.said["tip_tolerances"], self.said["axis_tolerances"], []
        if tip is not None:
            along = told_tolerances(tip, tip=True).tip_along(self.toolpath)
            checks.append(self.same("tip_tolerance_mm", float(along.max()) / MILLIMETRE))
        if axis is not None:
            along = told_tolerances(axis, tip=False).axis_along(self.toolpath)
            checks.append(self.same("axis_tolerance_deg", float(along.max()) / DEGREE))
        return checks

    def of_time(self) -> list[Check]:
        """Duration, time step and number of set-points."""
        t, said = self.points.t, float(self.said["duration_s"])
        last, step = float(t[-1]), self.verification.dt
        ok = last - step < said * (1.0 + 1e-12) and said <= last * (1.0 + 1e-12)
        checks = [Check("plan.json duration_s", said, last, "s", ok, note="it ends within the last time step")]
        ok = abs(float(t[0])) <= SAME * step
        checks.append(Check("begin of time", float(t[0]), 0.0, "s", ok, note="set-points begin at 0"))
        return [*checks, self.same("dt_s", step, "s"), self.same("set_points", len(t))]

    def of_bounds(self) -> list[Check]:
        """Bounds lie below the duration, and the gap is what they leave."""
        said, duration = self.said, float(self.said["duration_s"])
        checks = []
        for key in ("lower_bound_s", "continuous_bound_s"):
            if said[key] is not None:
                bound = float(said[key])
                ok = 0.0 < bound <= duration * (1.0 + SAME)
                checks.append(Check(f"plan.json {key}", bound, duration, "s", ok, note="not above the duration"))
        of = "this mesh" if said["lower_bound_s"] is not None else None
        checks.append(wrong("lower_bound_of", f"says {said['lower_bound_of']!r}", said["lower_bound_of"] == of))
        if (said["gap"] is None) != (said["lower_bound_s"] is None):
            checks.append(wrong("gap", "a gap goes with a lower bound, and none with none"))
        elif said["gap"] is not None:
            right = duration / float(said["lower_bound_s"]) - 1.0 if said["lower_bound_s"] else math.inf
            ok = abs(float(said["gap"]) - right) <= 1e-9 * (1.0 + right)
            checks.append(Check("plan.json gap", float(said["gap"]), right, "", ok, note=f"found: {right:.6g}"))
        return checks

    def of_counts(self) -> list[Check]:
        """Blocks and stops of the program, length of the way; numbers and times that cannot be negative."""
        said, checks = self.said, []
        if self.toolpath is not None:
            blocks = self.toolpath.blocks or len(set(self.toolpath.block.tolist()))
            checks += [self.same("blocks", blocks), self.same("stops", int(self.toolpath.stop[1:-1].sum()))]
        if said["path_length_mm"] is not None and self.points.has_tool:
            length = float(way_lengths(self.points, self.points.tip, self.points.axis).sum())
            checks.append(self.same("path_length_mm", length * 1e3, "", 1e-7))
        else:
            note = "is not given" if self.points.has_tool else "cannot be found: set-points have no tip and axis"
            checks.append(wrong("path_length_mm", note))
        times = {"solve_s": said["solve_s"], "fit_s": said["fit_s"], "mesh_points": said["mesh_points"]}
        times |= {f"step_s {name}": value for name, value in said["step_s"].items()}
        bad = [name for name, value in times.items() if not (math.isfinite(value) and value >= 0.0)]
        checks.append(wrong(", ".join(bad) or "times", "are no times or counts" if bad else "none negative", not bad))
        return checks

    def of_names(self) -> list[Check]:
        """The machine, and words that must be there."""
        said = self.said
        ok = said["machine"] == self.machine.name
        checks = [wrong("machine", f"says {said['machine']!r}, machine.toml is of {self.machine.name!r}", ok)]
        empty = [key for key in ("planner", "toolpace_version", "program") if not str(said[key]).strip()]
        if empty:
            checks.append(wrong(", ".join(empty), "is empty"))
        if said["verified"] is not None:
            ok = said["verified"] == self.verification.ok
            checks.append(wrong("verified", f"says {said['verified']}".lower(), ok))
        return checks

    def of_reading(self) -> list[Check]:
        """What the program is for, what was taken for granted and passed over, and the time of its operations."""
        if self.toolpath is None:
            return []
        right = {
            "controller": printable(self.toolpath.controller),
            "assumed": [printable(sentence) for sentence in self.toolpath.assumed],
            "skipped": {printable(word): count for word, count in self.toolpath.skipped.items()},
        }
        checks = [wrong(key, f"found: {value!r:.200}", self.said[key] == value) for key, value in right.items()]
        return checks + OperationFigures(self.said, self.toolpath, self.passages, self.verification.dt).checks()

    def of_bending(self) -> list[Check]:
        """How far the tool bends, where that is compensated; how near it is known, after how many iterations."""
        said = self.said["bending"]
        if said is None:
            return []
        largest, right = float(said["largest_mm"]) * 1e-3, self.verification.bending
        ok = abs(largest - right) <= SAME_BENDING
        check = Check("plan.json bending largest_mm", largest, right, "m", ok, note=f"found: {right * 1e3:.6g} mm")
        change, rounds = float(said["change_um"]), int(said["rounds"])
        near = 0.0 <= change <= MOST_CHANGE and 0 <= rounds <= MOST_ROUNDS
        return [check, wrong("bending change_um, rounds", f"{change:.3g} um, {rounds}", near)]

    def of_cut(self) -> list[Check]:
        """Times in air and in material: those of the operations sum up to them, and they to the time at feed at most;
        what is removed and what is left to the stock."""
        said = self.said["cut"]
        if said is None:
            return []
        times = [float(said[key]) for key in ("air_s", "cutting_s", "uncertain_s")]
        parts = [sum(float(each[key]) for each in said["operations"]) for key in ("air_s", "cutting_s", "uncertain_s")]
        stock, removed, left = (float(said[key]) for key in ("stock_mm3", "removed_mm3", "left_mm3"))
        cells = min(float(said["resolution_mm"]), float(said["collisions"]) + 1.0)
        ok = all(abs(whole - part) <= SAME * (1.0 + whole) for whole, part in zip(times, parts))
        ok &= min(*times, stock, removed, left, float(said["uncertainty_mm"])) >= 0.0 < cells
        ok &= sum(times) <= float(self.said["cutting_s"] or 0.0) + SAME * (1.0 + sum(times)) + CUT_TIME
        ok &= abs(removed + left - stock) <= CUT_VOLUME * stock
        shown = f"air {times[0]:.6g} s, material {times[1]:.6g} s, {removed:.6g} mm3 of {stock:.6g} mm3"
        return [wrong("cut", shown, ok)]

    def of_rounds(self) -> list[Check]:
        """The rounds of fit and pace: times that can be, kept where they are the least so far; and shares."""
        said, least = self.said, math.inf
        bad = "" if said["effort"] in EFFORTS else f"effort is {said['effort']!r:.40}"
        for each in said["rounds"]:
            duration = float(each["duration_s"])
            if not (math.isfinite(duration) and duration > 0.0) or bool(each["kept"]) != (duration < least):
                bad = f"a round of {duration:g} s, the least before {least:g} s, kept: {str(each['kept']).lower()}"
            least = min(least, duration)
        for key in ("tip_at_tolerance", "axis_at_tolerance"):
            share = said[key]
            if share is not None and not 0.0 <= float(share) <= 1.0 + SAME:
                bad = f"{key} is {share:g}, no share"
        shown = f"{said['effort']}, {len(said['rounds'])} rounds"
        return [wrong("effort, rounds, at_tolerance", bad or shown, not bad)]

    def of_deviations(self) -> list[Check]:
        """How far the motion strays, and the tolerances it is judged by."""
        if self.toolpath is None:
            return [wrong("program_file", "is empty: there is no program to hold the motion against")]
        checks = []
        for part, unit, right in (
            ("tip", "mm", self.verification.tip_deviation * 1e3),
            ("axis", "deg", math.degrees(self.verification.axis_deviation)),
        ):
            key = f"{part}_deviation_{unit}"
            if self.said[key] is None or not math.isfinite(right):
                checks.append(wrong(key, "is not given", self.said[key] is None and not math.isfinite(right)))
            else:
                said = float(self.said[key])
                ok = abs(said - right) <= 1e-6 * right + 1e-9
                checks.append(Check(f"plan.json {key}", said, right, "", ok, note=f"found: {right:.6g}"))
            key = f"{part}_tolerance_{unit}"
            said = self.said[key]
            if said is None or not (math.isfinite(said) and said > 0.0):
                checks.append(wrong(key, "is not given: there is nothing to judge by"))
        return checks

    def of_places(self) -> list[Check]:
        """Places where time could be gained: in order of time, within the motion, in the block that they name."""
        places, duration = self.said["open_places"], float(self.said["duration_s"])
        if not places:
            return []
        bad, before = "", 0.0
        for place in places:
            start, end, gain_s = (float(place[key]) for key in ("from_s", "to_s", "gain_s"))
            if not (before - SAME <= start <= end <= duration * (1.0 + SAME) and 0.0 <= gain_s <= duration):
                bad = f"from {start:g} s to {end:g} s, gain {gain_s:g} s"
            before = start
            k = int(np.searchsorted(self.points.t, start))
            near, block = self.points.block[max(k - EARLY, 0) : k + EARLY + 1], int(place["block"])
            every = near if self.toolpath is None else self.toolpath.block
            # Short blocks begin and end between two set-points: none of these names them.
            if not near.min() <= block <= near.max() or block not in every:
                bad = f"block {place['block']} is not passed at {start:g} s"
        return [wrong("open_places", bad or f"{len(places)} places", not bad)]


def with_table(found: Verification, path: Path, points: SetPoints, machine: Machine) -> Verification:
    """A verification with the check of the table added."""
    return replace(found, checks=(*found.checks, table_check(path, points, machine)))


def table_check(path: Path, points: SetPoints, machine: Machine) -> Check:
    """Whether each number of the table is that of the set-points, in millimetres and degrees."""
    names, factors = _columns(points, machine)
    values = [points.t[:, None], points.q, points.qd, points.qdd, points.qddd, points.tip, points.axis]
    values.append(points.block[:, None].astype(np.float64))
    try:
        with path.open(encoding="ascii") as stream:
            head = stream.readline().rstrip("\r\n").split(",")
            if head != names:
                return _wrong("its columns are not those of set-points in mm and deg")
            row = 0
            while row < len(points):
                lines = list(itertools.islice(stream, min(CHUNK, len(points) - row)))
                if not lines:
                    break
                table = np.loadtxt(lines, delimiter=",", ndmin=2)
                part = slice(row, row + len(table))
                right = np.hstack([value[part] for value in values]) * factors
                if table.shape != right.shape or not _same(table, right):
                    return _wrong(f"rows {row + 1} to {row + len(table)} hold other numbers than the set-points")
                row += len(table)
            if row < len(points) or stream.read(1):
                return _wrong(f"it has not as many rows as there are set-points ({len(points)})")
    except OSError as error:
        raise UsageError(f"{path}: cannot read: {reason(error)}") from None
    except ValueError:
        return _wrong("it holds what is no number")
    return Check("setpoints.csv", 0.0, 0.0, "", True, note="as the set-points")


def _wrong(note: str) -> Check:
    return Check("setpoints.csv", 0.0, 0.0, "", False, note=note)


def _same(table: Floats, right: Floats) -> bool:
    return bool((np.abs(table - right) <= ROUNDING * np.abs(right) + 1e-300).all())


def _columns(points: SetPoints, machine: Machine) -> tuple[list[str], Floats]:
    """Names with units, and the factors from SI."""
    names, factors = ["t [s]"], [1.0]
    for kind, _, per in COLUMNS:
        for joint, rotary in zip(points.joints, machine.is_rotary):
            names.append(f"{joint}{kind} [{'deg' if rotary else 'mm'}{per}]")
            factors.append(180.0 / math.pi if rotary else 1e3)
    if points.has_tool:
        names += [f"tip {c} [mm]" for c in "xyz"] + [f"axis {c} [1]" for c in "ijk"]
        factors += [1e3] * 3 + [1.0] * 3
    return [*names, "block"], np.array([*factors, 1.0])
