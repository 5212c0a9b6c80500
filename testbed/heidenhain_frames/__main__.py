"""python -m testbed.heidenhain_frames [--first SEED] [--programs N]: what came of random programs, by machine."""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict

from testbed.heidenhain_frames.held import EXPECTED, held
from testbed.heidenhain_frames.words import MACHINES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--programs", type=int, default=300)
    given = parser.parse_args()
    rows: dict[str, list[float]] = defaultdict(lambda: [0, 0, 0, 0, 0.0, 0.0, 0.0])
    refusals: Counter[str] = Counter()
    for seed in range(given.first, given.first + given.programs):
        found, row = held(seed), rows[MACHINES[seed % len(MACHINES)]]
        row[0] += 1
        if found.refused:
            row[1] += 1
            known = next((part for part in EXPECTED if part in found.refused), "")
            refusals[known or found.refused[:150]] += 1
            if not known:
                print(f"{seed}: refused: {found.refused}", flush=True)
            continue
        if found.wrong:
            row[2] += 1
            print(f"{seed}: {found.wrong}", flush=True)
        row[3] += found.blocks
        row[4], row[5], row[6] = max(row[4], found.tip), max(row[5], found.axis), max(row[6], found.way)
    print(f"{'':28} {'programs':>8} {'refused':>8} {'wrong':>6} {'blocks':>7} {'tip m':>8} {'axis':>8} {'way m':>8}")
    for name, (count, refused, wrong, blocks, tip, axis, way) in rows.items():
        print(f"{name:28} {count:8.0f} {refused:8.0f} {wrong:6.0f} {blocks:7.0f} {tip:8.1e} {axis:8.1e} {way:8.1e}")
    for part, count in refusals.most_common():
        print(f"{count:6d} refused: {part}")


if __name__ == "__main__":
    main()
