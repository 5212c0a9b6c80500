"""Follow plans with all that may be measured and asked for, and judge every set-point.

python -m benchmarks.followed --runs 2000 --seed 0
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.machine import written_by
from benchmarks.tables import Table
from testbed.followed.campaign import campaign
from testbed.followed.cases import CASES
from testbed.followed.judge import Verdict
from toolpace.common.arrays import Floats
from toolpace.deflection.following import Status


@dataclass
class Tally:
    """What came of the runs of a case."""

    runs: int = 0
    failed: int = 0
    ended: int = 0
    jumps: int = 0
    seconds: float = 0.0
    worst: Floats = field(default_factory=lambda: np.zeros(6))
    """Velocity, acceleration, jerk, feed, off the path, travel: see Verdict."""
    said: Counter[Status] = field(default_factory=Counter)

    def count(self, seconds: float, verdict: Verdict) -> None:
        """Add a run."""
        self.runs, self.seconds, self.jumps = self.runs + 1, self.seconds + seconds, self.jumps + verdict.jumps
        self.failed, self.ended = self.failed + (not verdict.fine), self.ended + verdict.ended
        row = [*verdict.limits, verdict.feed, verdict.off_path, max(verdict.travel, 0.0)]
        self.worst = np.maximum(self.worst, row)
        self.said.update(each for each in Status if each & verdict.said)

    def cells(self) -> list[str]:
        """A line of the table."""
        return [
            f"{self.runs}", f"{self.seconds:.0f}", f"{self.failed}", f"{self.ended}", f"{self.jumps}",
            *(f"{value:.5f}" for value in self.worst[:5]), f"{self.worst[5]:.1e}",
        ]  # fmt: skip


HEADS = [
    "case", "runs", "time [s]", "failed", "gone through", "jumps of state", "velocity", "acceleration", "jerk", "feed",
    "off the path", "beyond travel [m, rad]",
]  # fmt: skip


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.followed", description=__doc__)
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", type=Path, default=None, help="write the table to this file")
    given = parser.parse_args()
    began, tallies = time.process_time(), {name: Tally() for name in CASES}
    for name, group, number, seconds, verdict in campaign(given.runs, given.seed):
        tallies[name].count(seconds, verdict)
        if not verdict.fine:
            print(f"{name}, figures {group}, run {number}: {verdict}", flush=True)
        if (done := sum(tally.runs for tally in tallies.values())) % 100 == 0:
            print(f"{done} runs, {time.process_time() - began:.0f} s of CPU time", flush=True)
    table = Table(
        "Worst of each case", HEADS, [[name, *tally.cells()] for name, tally in tallies.items() if tally.runs]
    )
    table.show()
    said = sum((tally.said for tally in tallies.values()), Counter())
    words = ", ".join(f"{status.name} in {count}" for status, count in said.most_common())
    print(words)
    if given.write is not None:
        given.write.write_text(
            page(table, words, f"python -m benchmarks.followed --runs {given.runs} --seed {given.seed}")
        )


def page(table: Table, words: str, command: str) -> str:
    """The results as a page."""
    return (
        "# Plans followed, whatever is measured\n\n"
        f"{written_by(command)}\n\n"
        "Random figures of the follower (reserve 0.02 to 0.4, period 0.5 to 4 ms, delay to 20 ms, both causes, gain\n"
        "to 1.6, filter, deadband, wait), random measurements (noise, steps, bang-bang, nan, absurd, late, out of\n"
        "order, from the future, none for a while; of tip, deflection, axis and force) and a random override with\n"
        "holds. All is judged by differences of the set-points: velocity, acceleration and jerk over the whole\n"
        "limits, the speed of the tip over feed times override, or pace where that is behind, and the stated excess,\n"
        "set-points less their correction over what is stated of the path. A run that has not gone through its path\n"
        "must say why it stands. Where joints are found displaced the state jumps, and no difference is taken\n"
        "across.\n\n"
        f"{table.markdown()}\nRuns in which a status was said: {words}.\n"
    )


if __name__ == "__main__":
    main()
