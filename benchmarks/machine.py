"""Where benchmarks ran, and where their results are kept."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("numpy", "numba", "scipy", "casadi", "copp-py", "toppra", "ruckig")


def machine() -> dict[str, object]:
    """Where this ran: processor, cores, versions."""
    model = platform.processor()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        model = names[0].split(":", 1)[1].strip() if names else model
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "commit": revision(),
        **{name: version(name) for name in PACKAGES},
    }


def machine_in_words() -> str:
    """The same on one line."""
    return ", ".join(f"{key} {value}" for key, value in machine().items())


def revision() -> str:
    """The commit that was measured, with a + where the tree differs from it."""
    try:
        words = subprocess.run(
            ["git", "describe", "--always", "--dirty=+"], cwd=RESULTS.parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return words.stdout.strip()
