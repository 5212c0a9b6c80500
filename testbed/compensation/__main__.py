"""python -m testbed.compensation [--first SEED] [--programs N] [--rules NAME ...]: contours by controls."""

from __future__ import annotations

import argparse
from collections import Counter

from testbed.compensation.held import ELSEWHERE, RULES, SAME, held
from testbed.compensation.written import Form


def main() -> int:
    """Try contours and print a table; 1 where one is elsewhere."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--programs", type=int, default=300)
    known = [rule for rule in RULES if rule != "type B"]  # an option of a controller's file
    parser.add_argument("--rules", nargs="+", choices=known, default=known)
    given = parser.parse_args()
    wrong = 0
    for rule in given.rules:
        outcomes: Counter[str] = Counter()
        worst = 0.0
        for seed in range(given.first, given.first + given.programs):
            found = held(seed, rule, Form())
            outcomes[found.outcome] += 1
            worst = max(worst, found.apart if found.outcome == SAME else 0.0)
            if found.outcome == ELSEWHERE:
                print(f"{rule}: seed {seed} is {found.apart:.4g} mm off")
        wrong += outcomes[ELSEWHERE]
        table = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
        print(f"{rule:12} {table}; worst of the same {worst * 1e3:.2f} um", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
