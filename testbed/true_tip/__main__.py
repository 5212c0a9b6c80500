"""python -m testbed.true_tip [--first SEED] [--cases N]: the worst of random cases, by machine and by mode."""

from __future__ import annotations

import argparse
from collections import defaultdict

from testbed.true_tip.cases import Maker
from testbed.true_tip.held import held
from toolpace.common.errors import ToolpaceError

STEP = 2.5e-4
"""Of set-points [s]: where the tip goes round a corner in a millisecond, chords between them are off by 0.4 um."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--effort", default="low")
    given = parser.parse_args()
    worst: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0.0, 0, 0, 0])
    for seed in range(given.first, given.first + given.cases):
        maker = Maker(seed)
        case = maker.make()
        if case is None:
            worst["no travel"][3] += 1
            continue
        try:
            found = held(case, given.effort, STEP)
        except ToolpaceError as error:
            print(f"{seed} {case.machine} {case.mode}: refused: {error}", flush=True)
            worst[case.machine][5] += 1
            continue
        bad = found.tip > 10.05e-6 or found.speed > 1.0002 or found.column > 1e-8 or not found.verified
        if bad:
            print(f"{seed} {case.machine} {case.mode} {maker.lengths}: {found}", flush=True)
        for key in (case.machine, case.mode, "all"):
            row = worst[key]
            row[0], row[1] = max(row[0], found.tip), max(row[1], found.speed)
            row[2] = max(row[2], found.column)
            row[3] += 1
            row[4] += bad
    print(f"{'':28} {'tip um':>8} {'speed/F':>9} {'column m':>9} {'cases':>6} {'bad':>4} {'refused':>7}")
    for key, (tip, speed, column, count, bad, refused) in worst.items():
        print(f"{key:28} {tip * 1e6:8.3f} {speed:9.5f} {column:9.1e} {count:6d} {bad:4d} {refused:7d}")


if __name__ == "__main__":
    main()
