"""Which limit binds when and where: utilisation of every limit over a motion, and the stretches in which one binds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.value_objects import ByValue, counted, one_line
from toolpace.machine.limits import Limits
from toolpace.motion.laws import TimeLaw
from toolpace.motion.usage import limit_ratios
from toolpace.path.axis_path import AxisPath

BINDING = 0.995
"""Share of a limit from which it counts as binding."""
RELEASED = 0.98
"""Share of a limit above which a stretch of it goes on where nothing binds for a moment: between the nodes of a mesh a
little less than the limit is used."""
NOTHING = "nothing"
"""What binds where no limit does."""


class ActiveStretch(NamedTuple):
    """A stretch of a run in which one limit binds, or none."""

    limit: str
    """As `limited_by` names it; "nothing" where no limit binds."""
    start: float
    end: float
    """When it is passed [s]."""
    run: int
    first: float
    last: float
    """Parameters s of the run at its ends."""
    used: float
    """Largest value over limit of what binds, or of any limit where none does."""
    block: int
    """Block of the program at its start; 0 where there is none."""


@dataclass(frozen=True, eq=False, repr=False)
class ActiveLimits(ByValue):
    """Utilisation of every limit at the n states of a motion's laws, in the order of time; dwells have none."""

    names: tuple[str, ...]
    """(k,) "feed", "velocity X", ..., "acceleration X", ..., "jerk X", ..., and rows of one's own."""
    t: Floats
    """(n,) when each state is passed [s]."""
    share: Floats
    """(n,) time that each state stands for [s]; sums to the duration without its dwells."""
    run: Ints
    """(n,) run of each state."""
    s: Floats
    """(n,) parameter of that run."""
    block: Ints
    """(n,) block of the program; 0 where there is none."""
    used: Floats
    """(n, k) value over limit; nan for jerk where a law's acceleration jumps, so that no figure bounds it."""

    def __repr__(self) -> str:
        return one_line(self, f"{counted(len(self.t), 'state')}, {counted(len(self.names), 'limit')}")

    @property
    def most(self) -> Ints:
        """(n,) the limit that is used most, by its place in `names`."""
        most: Ints = np.nan_to_num(self.used, nan=-1.0).argmax(axis=1)
        return most

    @property
    def binds(self) -> Bools:
        """(n, k) whether a limit binds: 0.995 of it is used, or more. Several may at once."""
        binds: Bools = self.used >= BINDING
        return binds

    def stretches(self) -> list[ActiveStretch]:
        """The stretches in which one limit is used most and binds, or none does, in the order of time."""
        most = self.most
        used = self.used[np.arange(len(self.t)), most]
        limit = np.where(used >= BINDING, most, len(self.names))
        for a, b in self._bounds(limit):
            if limit[a] == len(self.names) and a > 0 and b < len(limit) - 1 and self.run[a - 1] == self.run[b + 1]:
                before, after = limit[a - 1], limit[b + 1]
                if before == after and self.used[a : b + 1, before].min() >= RELEASED:
                    limit[a : b + 1] = before
        names = (*self.names, NOTHING)
        return [
            ActiveStretch(
                names[limit[a]], self._between(a - 1, a), self._between(b + 1, b), int(self.run[a]), float(self.s[a]),
                float(self.s[b]), float(used[a : b + 1].max()), int(self.block[a]),
            )
            for a, b in self._bounds(limit)
        ]  # fmt: skip

    def _between(self, other: int, state: int) -> float:
        """The time midway between two states; that of `state` where the other is of another run, or there is none."""
        if 0 <= other < len(self.t) and self.run[other] == self.run[state]:
            return float(self.t[other] + self.t[state]) / 2.0
        return float(self.t[state])

    def _bounds(self, limit: Ints) -> list[tuple[int, int]]:
        """The first and the last state of each stretch of one run in which `limit` (n,) is the same."""
        begins = np.flatnonzero((np.diff(limit, prepend=-1) != 0) | (np.diff(self.run, prepend=-1) != 0))
        return list(zip(begins.tolist(), (np.append(begins[1:], len(limit)) - 1).tolist()))

    def table(self) -> str:
        """The stretches as text, one a line: limit, from and to [s], from and to s, largest share of the limit."""
        lines = [("limit", "from [s]", "to [s]", "from s", "to s", "used")]
        for one in self.stretches():
            times, places = (f"{one.start:.4f}", f"{one.end:.4f}"), (f"{one.first:.6g}", f"{one.last:.6g}")
            lines.append((one.limit, *times, *places, f"{one.used:.4f}"))
        first = max(len(line[0]) for line in lines)
        return "\n".join("  ".join([line[0].ljust(first), *(cell.rjust(9) for cell in line[1:])]) for line in lines)


def active_limits(axis_path: AxisPath, limits: Limits, laws: tuple[TimeLaw, ...], starts: Floats) -> ActiveLimits:
    """What a motion uses of its limits, where its laws are probed; `starts` (runs,) is when each run starts [s]."""
    jerks, parts = limits.orders == 2, []
    for k, (run, law) in enumerate(zip(axis_path.runs, laws)):
        for probe in law.probes():
            used = limit_ratios(run, limits, probe.state, probe.right)
            if law.jumps.size:
                used[:, jerks] = np.nan
            s = np.clip(probe.state[0], run.s0, run.s1)
            parts.append((starts[k] + law.times_at(s), probe.share, np.full(len(s), k), s, run.block_at(s), used))
    t, share, run_of, s, block, used = (np.concatenate(column) for column in zip(*parts))
    return ActiveLimits(tuple(limits.names), t, share, run_of, s, block, used)
