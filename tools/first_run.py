"""What a first run compiles, and how long it takes: `python tools/first_run.py`, from an empty cache.

Prints kernels, specialisations and seconds. Fails where a kernel was compiled for two signatures, or where the demo
compiled one that was not compiled beforehand: then `python tools/first_run.py --record` writes the signatures anew.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path


def main() -> int:
    """Measure, or record."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TOOLPACE_CACHE"] = folder
        if "--record" in sys.argv:
            return record(Path(folder))
        began = time.perf_counter()
        subprocess.run([sys.executable, "-m", "toolpace.kernels.ahead_of_time"], check=True)
        seconds = time.perf_counter() - began
        processor = time_of_children()
        ahead_of_time = kernel_files(Path(folder))
        demo = [sys.executable, "-m", "toolpace", "demo", "--out", str(Path(folder) / "demo")]
        subprocess.run(demo, check=True, stdout=subprocess.DEVNULL)
        late = sorted(set(kernel_files(Path(folder))) - set(ahead_of_time))
        count = Counter(name.rpartition("-")[0] for name in [*ahead_of_time, *late])
    twice = sorted(name for name, times in count.items() if times > 1)
    print(f"first run: {len(count)} kernels, {count.total()} specialisations")
    print(f"compiled in {seconds:.1f} s ({processor:.1f} s of processor time)")
    for name in twice:
        print(f"compiled for {count[name]} signatures: {name}")
    for name in late:
        print(f"compiled by the demo, not beforehand: {name.rpartition('-')[0]}")
    return 1 if twice or late else 0


def time_of_children() -> float:
    """Processor time of the processes that have ended [s]."""
    used = os.times()
    return used.children_user + used.children_system


def kernel_files(base: Path) -> list[str]:
    """Names of compiled kernels below a folder."""
    return sorted(each.name for each in base.rglob("*.kernel"))


def record(folder: Path) -> int:
    """Write the signatures of all kernels that a demo compiles."""
    from toolpace.cli import main as toolpace
    from toolpace.kernels import ahead_of_time, compile_order
    from toolpace.kernels.jit import KERNELS

    ahead_of_time.is_warm = lambda: True  # nothing is compiled beforehand
    toolpace(["demo", "--out", str(folder / "demo")])
    found = {}
    for name, kernel in KERNELS.items():
        for each in kernel.signatures[:1]:
            found[name] = [compile_order.to_text(kind) for kind in each]
        for each in kernel.signatures[1:]:
            print(f"compiled again: {name}{each}")
    compile_order.write_signatures(found)
    print(f"{len(found)} kernels")
    return 0


if __name__ == "__main__":
    sys.exit(main())
