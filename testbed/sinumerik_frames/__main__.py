"""python -m testbed.sinumerik_frames [--first SEED] [--programs N]: the worst of random programs, by machine."""

from __future__ import annotations

import argparse
import re
from collections import Counter, defaultdict

from testbed.sinumerik_frames.compare import compare
from testbed.sinumerik_frames.programs import Program

MOST = 1e-6
"""Of what a tip may be off [m]."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--programs", type=int, default=3000)
    parser.add_argument("--show", action="store_true", help="write each bad program with its sheet")
    given = parser.parse_args()
    worst: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0.0, 0, 0, 0])
    reasons: Counter[str] = Counter()
    for seed in range(given.first, given.first + given.programs):
        program = Program(seed)
        report = compare(program)
        bad = report.off > MOST or report.beside > MOST or report.axis > MOST
        if report.refused:
            reasons[re.sub(r"\d[\d.]*", "0", report.refused.split(" in '")[0])[:110]] += 1
        if bad:
            print(f"seed {seed} {program.machine}: {report}", flush=True)
            if given.show:
                print(program.text())
                print(program.sheet())
        for key in (program.machine, "all"):
            row = worst[key]
            row[0], row[1] = max(row[0], report.off), max(row[1], report.axis)
            row[2] = max(row[2], report.beside)
            row[3] += 1
            row[4] += bad
            row[5] += bool(report.refused)
    print(f"{'':28} {'tip m':>9} {'axis':>9} {'beside m':>9} {'programs':>8} {'bad':>4} {'refused':>7}")
    for key, (tip, axis, beside, count, bad, refused) in worst.items():
        print(f"{key:28} {tip:9.1e} {axis:9.1e} {beside:9.1e} {count:8d} {bad:4d} {refused:7d}")
    for reason, count in reasons.most_common():
        print(f"{count:5d} {reason}")


if __name__ == "__main__":
    main()
