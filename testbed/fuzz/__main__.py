"""The command: fuzz dialects for so much CPU time each, and end with 1 where something is wrong."""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import tempfile
from pathlib import Path

from testbed.fuzz import coverage


def main() -> int:
    """Fuzz, and print what was done and found."""
    parser = argparse.ArgumentParser(prog="python -m testbed.fuzz", description=__doc__)
    parser.add_argument("dialect", nargs="+", help="name of a controller, or cldata, csv, setup, controller, or all")
    parser.add_argument("--seconds", type=float, default=60.0, help="CPU time of each (60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, help="folder for inputs that go wrong")
    given = parser.parse_args()
    coverage.install()
    from testbed.fuzz.campaign import Campaign
    from testbed.fuzz.targets import targets

    known = targets()
    names = list(known) if given.dialect == ["all"] else given.dialect
    if unknown := set(names) - set(known):
        parser.error(f"{', '.join(sorted(unknown))}: none of {', '.join(known)}")
    out = given.out.resolve() if given.out else None
    wrong = 0
    with tempfile.TemporaryDirectory() as empty:
        os.chdir(empty)  # programs that are called are looked for beside the one that is read
        for name in names:
            campaign = Campaign(known[name], given.seed)
            campaign.run(given.seconds, lambda text: print(text, flush=True))
            print(campaign.state(), flush=True)
            wrong += len(campaign.found)
            for found in campaign.found.values() if out else ():
                folder = out / name if out else Path()
                folder.mkdir(parents=True, exist_ok=True)
                key = hashlib.sha256(found.kind.encode()).hexdigest()[:10]
                (folder / key).write_bytes(found.data)
                (folder / f"{key}.txt").write_text(f"{found.kind}\n{found.asked}\n{found.told}\n", errors="replace")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
