"""What a first run compiles, and how long it takes: `python tools/first_run.py`, from an empty cache.

The cache is that of this user where nothing is compiled in it yet: what comes next need not compile again.
Prints kernels, specialisations and seconds. Fails where a kernel was compiled for two signatures, or where the demo
compiled one that was not compiled beforehand: then `python tools/first_run.py --record` writes the signatures anew,
and beside them those that other usual commands compile besides, for wheels.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from toolpace.kernels.compile_order import Text

MACHINE = "xyzac-trunnion"
PROGRAM = """G21 G90 G54
T1 M6
G43.4 H1
G1 X10 Y0 Z10 A0 C0 F1000
X20 Y5
X30 Y5 A5
X40 Y0
M30
"""


SHEET = """[stock]
box = [[0, -20, -20], [60, 40, 5]]
uncertainty = 0.3
[tools.1]
kind = "flat"
diameter = 10
flute_length = 20
teeth = 3
stick_out = 40
spindle_speed = 6000
material = "carbide"
"""


def main() -> int:
    """Measure, or record."""
    from toolpace.kernels.kernel_cache import store

    kernels = store().folder
    with tempfile.TemporaryDirectory() as folder:
        recording = "--record" in sys.argv
        if recording or kernels is None or store().files():
            os.environ["TOOLPACE_CACHE"] = folder
            kernels = Path(folder)
        if recording:
            store.cache_clear()
            return record(Path(folder))
        began = time.perf_counter()
        subprocess.run([sys.executable, "-m", "toolpace.kernels.ahead_of_time"], check=True)
        seconds = time.perf_counter() - began
        processor = time_of_children()
        ahead_of_time = kernel_files(kernels)
        demo = [sys.executable, "-m", "toolpace", "demo", "--out", str(Path(folder) / "demo")]
        subprocess.run(demo, check=True, stdout=subprocess.DEVNULL)
        late = sorted(set(kernel_files(kernels)) - set(ahead_of_time))
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
    """Write the signatures of all kernels that a demo compiles, and of those that other usual commands add."""
    from toolpace.cli import main as toolpace
    from toolpace.kernels import ahead_of_time, compile_order
    from toolpace.kernels.jit import KERNELS

    ahead_of_time.is_warm = lambda: True  # nothing is compiled beforehand
    toolpace(["demo", "--out", str(folder / "demo")])
    of_demo = compiled_now()
    compile_order.write_signatures(of_demo)
    run_other_commands(folder)
    further = {name: kinds for name, kinds in compiled_now().items() if name not in of_demo}
    compile_order.write_signatures(further, compile_order.FURTHER)
    for name, kernel in KERNELS.items():
        for each in kernel.signatures[1:]:
            print(f"compiled again: {name}{each}")
    print(f"{len(of_demo)} kernels, {len(further)} more of other commands")
    return 0


def compiled_now() -> dict[str, list[Text]]:
    """Signatures of the kernels that this process has compiled or loaded, by name; of several the first."""
    from toolpace.kernels.compile_order import to_text
    from toolpace.kernels.jit import KERNELS

    compiled = {name: kernel.signatures[0] for name, kernel in KERNELS.items() if kernel.signatures}
    return {name: [to_text(kind) for kind in signature] for name, signature in compiled.items()}


def run_other_commands(folder: Path) -> None:
    """Run what people use besides `plan`: other planners, times of controls, set-ups, a follower, feeds by the cut."""
    import toolpace as tp
    from toolpace.cli import main as toolpace

    program, planned = folder / "part.ngc", folder / "part-plan"
    program.write_text(PROGRAM, "ascii")
    on_machine = [str(program), "--machine", MACHINE]
    for planner in ("genetic", "second-order"):
        toolpace(["plan", *on_machine, "--planner", planner, "--out", str(folder / planner)])
    toolpace(["time", *on_machine])
    toolpace(["setup", *on_machine, "--trials", "20", "--workers", "0", "--out", str(folder / "setup")])
    toolpace(["plan", *on_machine, "--out", str(planned)])
    tp.Follower.from_folder(planned, reserve=0.1).step()
    sheet = folder / "setup.toml"
    sheet.write_text(SHEET, "ascii")
    with_sheet = [*on_machine, "--setup", str(sheet), "--resolution", "1mm"]
    toolpace(["feeds", *with_sheet, "--feeds", "learned"])
    toolpace(["plan", *with_sheet, "--feeds", "limits", "--limit", "chip=0.05mm", "--out", str(folder / "within-cut")])


if __name__ == "__main__":
    sys.exit(main())
