"""Where benchmarks ran, with what memory, and where their results are kept."""

from __future__ import annotations

import datetime
import os
import platform
import resource
import subprocess
from importlib.metadata import version
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("numpy", "numba", "scipy", "casadi", "copp-py", "toppra", "ruckig")


def machine() -> dict[str, object]:
    """Where this ran: processor, cores, versions."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "commit": revision(),
        **{name: version(name) for name in PACKAGES},
    }


def processor() -> str:
    """The name of the processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def most_memory() -> float:
    """Of this process so far [MB]. What `resource` says counts the parent that started it, too."""
    status = Path("/proc/self/status")
    if status.exists():
        return float(status.read_text().split("VmHWM:")[1].split()[0]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def written_by(command: str, took: str = "") -> str:
    """The first sentences of a page of results: what wrote it, when, in what time, and where."""
    where = ", ".join(f"{key} {value}" for key, value in machine().items())
    when = datetime.date.today().isoformat() + (f", {took}" if took else "")
    return f"Written by `{command}` on {when}. Machine: {where}."


def revision() -> str:
    """The commit that was measured, with a + where the tree differs from it."""
    try:
        words = subprocess.run(
            ["git", "describe", "--always", "--dirty=+"], cwd=RESULTS.parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return words.stdout.strip()
