"""A wheel for this platform that brings compiled kernels: `python tools/wheel.py [FOLDER]`, dist by default.

The kernels of a first run, and those of other usual commands, are compiled for each baseline of the processor, in a
folder of their own; `hatch_build.py` takes them into the wheel. Where an installation has other versions of numba,
NumPy or Python, they are compiled anew.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from toolpace.kernels.baseline import baselines

REPOSITORY = Path(__file__).parents[1]
COMPILE = "from toolpace.kernels.ahead_of_time import warm_up as go; go(further=True)"
COPY = (
    "import sys; from pathlib import Path; "
    "from toolpace.kernels.kernel_cache import write_built as go; go(Path(sys.argv[1]))"
)


def main() -> int:
    """Compile for each baseline, then build."""
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "dist").absolute()
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        for processor, features in baselines().items():
            began = time.perf_counter()
            environment = {**os.environ, "NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": features}
            environment["TOOLPACE_CACHE"] = str(place / "cache")
            subprocess.run([sys.executable, "-c", COMPILE], env=environment, check=True)
            subprocess.run([sys.executable, "-c", COPY, str(place / "built" / processor)], env=environment, check=True)
            count = len(list((place / "built" / processor).glob("*.kernel")))
            print(f"{count} kernels for {processor} in {time.perf_counter() - began:.0f} s", flush=True)
        build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(out), str(REPOSITORY)]
        subprocess.run(build, env={**os.environ, "TOOLPACE_BUILT": str(place / "built")}, check=True)
    newest = max(out.glob("toolpace-*.whl"), key=lambda file: file.stat().st_mtime)
    print(f"{newest} ({newest.stat().st_size / 1e6:.1f} MB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
