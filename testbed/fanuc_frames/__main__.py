"""python -m testbed.fanuc_frames [--first SEED] [--programs N] [--show]: the worst of random programs, by machine."""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter, defaultdict

from testbed.fanuc_frames.held import held

MOST_OFF, MOST_TURNED = 1e-6, 1e-7
"""Beyond which a program is wrong [m, rad]."""


def main() -> int:
    """Try programs and print a table; 1 where one is elsewhere."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--programs", type=int, default=300)
    parser.add_argument("--show", action="store_true", help="print the first program that is elsewhere")
    given = parser.parse_args()
    table: dict[str, list[float]] = defaultdict(lambda: [0, 0, 0, 0, 0.0])
    refusals: Counter[str] = Counter()
    words: Counter[str] = Counter()
    wrong = 0
    for seed in range(given.first, given.first + given.programs):
        found, program = held(seed)
        words += found.words
        bad = found.off > MOST_OFF or found.turned > MOST_TURNED or found.length > 1e-9 or found.other > 0
        for key in (program.by.name, program.machine, "all"):
            row = table[key]
            row[0] += 1
            row[1] += bool(found.refused)
            row[2] += found.places
            row[3] += bad
            row[4] = max(row[4], found.off)
        if found.refused:
            refusals[re.sub(r"[-+]?\d+\.\d+|'[^']*'$|:\d+", "..", found.refused)[:150]] += 1
        if bad:
            wrong += 1
            if wrong <= 5:
                print(f"{seed} {program.by.name} {program.machine}: {found}"[:300])
            if wrong == 1 and given.show:
                print("\n".join(f"{n:4d} {line}" for n, line in enumerate(program.lines, 1)))
    print(f"{'':28} {'programs':>8} {'refused':>8} {'places':>8} {'wrong':>6} {'off um':>9}")
    for key, (count, refused, places, bad, off) in table.items():
        print(f"{key:28} {count:8.0f} {refused:8.0f} {places:8.0f} {bad:6.0f} {off * 1e6:9.6f}")
    print("words:", ", ".join(f"{word} {count}" for word, count in words.most_common(40)))
    for message, count in refusals.most_common():
        print(f"{count:6d} {message}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
