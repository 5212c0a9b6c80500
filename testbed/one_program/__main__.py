"""python -m testbed.one_program [--programs N] [--first SEED] [--show] [DIALECT ...]"""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from testbed.one_program.run import WRITERS, tried


def main() -> int:
    """Try programs, print a table; 1 where any motion differs."""
    parser = argparse.ArgumentParser(description="One program in every dialect, each read, all one motion.")
    parser.add_argument("dialects", nargs="*", default=[], help="all where none is named")
    parser.add_argument("--programs", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--show", action="store_true", help="print the text of the first that differs")
    parser.add_argument("--faults", type=int, default=5, help="how many differences to print a dialect")
    asked = parser.parse_args()
    wrong = 0
    for dialect in asked.dialects or WRITERS:
        said: Counter[str] = Counter()
        expanded: Counter[str] = Counter()
        written = faults = 0
        for seed in range(asked.first, asked.first + asked.programs):
            outcome = tried(dialect, seed)
            written += bool(outcome.text)
            said += outcome.said
            expanded += outcome.expanded
            if outcome.fault:
                faults += 1
                if faults <= asked.faults:
                    print(f"{dialect} {seed}: {outcome.fault}")
                if faults == 1 and asked.show:
                    print("\n".join(f"{n:4d} {line}" for n, line in enumerate(outcome.text.splitlines(), 1)))
        print(f"{dialect}: {written} of {asked.programs} written, {faults} differ")
        print("  said:", ", ".join(f"{name} {count}" for name, count in sorted(said.items())))
        print("  written out:", ", ".join(f"{name} {count}" for name, count in sorted(expanded.items())))
        wrong += faults
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
