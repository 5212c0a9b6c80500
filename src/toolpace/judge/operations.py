"""The operation times that are possible, from when the motion can pass the program's points.

Between which times a point is passed is known to what the tolerances leave open; where an operation begins and ends
at such a point, its time is known to that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import printable
from toolpace.judge.usage import wrong
from toolpace.judge.verification import Check
from toolpace.programs.toolpath import ToolPath

SAME = 1e-9
"""Share of the duration to which sums agree."""
PASSING = 0.01
"""Share of a time step to which it is known when a place is passed."""


@dataclass(frozen=True)
class Passages:
    """Between which times the motion can be at each point of the program."""

    early: Floats
    """(n,) [s]"""
    late: Floats
    """(n,) [s]"""


@dataclass(frozen=True)
class OperationFigures:
    """The operations of plan.json, and what they are judged by."""

    said: Mapping[str, Any]
    """plan.json, key by key."""
    toolpath: ToolPath
    passages: Passages | None
    """None where the motion is not that of the program."""
    dt: float
    """[s]"""

    def checks(self) -> list[Check]:
        """Names, tools, stops and dwells as the program has them; times within what is known; sums."""
        said = self.said["operations"]
        path, count = self.toolpath, len(self.toolpath.operations)
        dwell = np.bincount(path.operation, path.dwell, count)
        stops = np.bincount(path.operation[1:-1], path.stop[1:-1], count)
        ways = np.bincount(path.operation[1:], minlength=count)
        listed = [k for k in range(count) if ways[k] or dwell[k] > 0.0]
        right = [(printable(path.operations[k].name), printable(path.operations[k].tool)) for k in listed]
        if [(each["name"], each["tool"]) for each in said] != right:
            return [wrong("operations", f"are not the {len(right)} of the program, in its order, with their tools")]
        checks = self._sums()
        for k, each in zip(listed, said):
            if each["stops"] != int(stops[k]) or abs(each["dwell_s"] - dwell[k]) > SAME * (1.0 + dwell[k]):
                note = f"the program has {int(stops[k])} stops and {dwell[k]:g} s of dwells in operation {k + 1}"
                checks.append(wrong("operations", note))
        if self.passages is not None:
            checks += self._times(listed)
        return checks

    def _sums(self) -> list[Check]:
        """Each operation is the sum of its parts, all of them are the totals, and these the duration."""
        said, duration = self.said["operations"], float(self.said["duration_s"])
        kinds = ("cutting_s", "rapid_s", "dwell_s")
        pairs = [(each["time_s"], sum(each[kind] for kind in kinds)) for each in said]
        pairs += [(_number(self.said[kind]), sum(each[kind] for each in said)) for kind in kinds]
        pairs.append((duration, sum(_number(self.said[kind]) for kind in kinds)))
        off = [abs(a - b) for a, b in pairs]
        ok = all(value <= SAME * max(duration, 1.0) for value in off) and all(
            each[kind] >= -SAME for each in said for kind in kinds
        )
        return [
            wrong("operations", "parts sum up to the duration" if ok else "parts do not sum up, or are negative", ok)
        ]

    def _times(self, listed: list[int]) -> list[Check]:
        """Time at feed and at rapid of each operation, against the least and the most that it can be; the worst."""
        least, most = self._bounds()
        worst, check = -np.inf, wrong("operations", "no operation moves", True)
        for row, kind in enumerate(("cutting_s", "rapid_s")):
            for k, each in zip(listed, self.said["operations"]):
                value, low, high = float(each[kind]), float(least[row, k]), float(most[row, k])
                beyond = max(low - value, value - high)
                if beyond > worst or not np.isfinite(value):
                    worst = beyond
                    name = each["name"] or each["tool"] or str(k + 1)
                    note = f"{kind} of operation {name}, from {low:.6g} s to {high:.6g} s"
                    check = Check("plan.json operations", value, high, "s", bool(beyond <= 0.0), note=note)
        return [check]

    def _bounds(self) -> tuple[Floats, Floats]:
        """(2, operations) least and most time at feed and at rapid."""
        path, passages = self.toolpath, self.passages
        assert passages is not None
        count, last = len(path.operations), len(path) - 1
        kind: Ints = path.operation[1:] + count * path.rapid[1:]
        first = np.flatnonzero(np.concatenate(([True], np.diff(kind) != 0)))
        begin, end = first, np.concatenate((first[1:], [last]))
        # A point that is waited at is there from its arrival to its departure.
        duration, dwell = float(self.said["duration_s"]), path.dwell
        noise = PASSING * self.dt
        early, late = passages.early - noise, passages.late + noise
        leave_first, leave_last = early + dwell, late.copy()
        come_first, come_last = early.copy(), late - dwell
        leave_first[0] = leave_last[0] = dwell[0]
        come_first[last] = come_last[last] = duration - dwell[last]
        waited = np.cumsum(dwell)
        inside = waited[end] - dwell[end] - waited[begin]
        rounding = 1e-12 * duration
        least = np.maximum(come_first[end] - leave_last[begin] - inside, 0.0) - rounding
        most = np.maximum(come_last[end] - leave_first[begin] - inside, 0.0) + rounding
        lowest, highest = np.zeros(2 * count), np.zeros(2 * count)
        np.add.at(lowest, kind[first], least)
        np.add.at(highest, kind[first], most)
        return lowest.reshape(2, count), highest.reshape(2, count)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
