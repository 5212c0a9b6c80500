"""Free memory and free disk space for results."""

from __future__ import annotations

import contextlib
import importlib
import math
import shutil
from pathlib import Path
from typing import Any

_CGROUP = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current")


def free_memory() -> float:
    """Bytes of memory that this process can still have; infinite where the system does not tell."""
    free = math.inf
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        free = 1024.0 * float(next(line for line in lines if line.startswith("MemAvailable:")).split()[1])
    with contextlib.suppress(OSError, ValueError):
        most, used = (float(Path(name).read_text(encoding="ascii")) for name in _CGROUP)
        free = min(free, most - used)
    with contextlib.suppress(ImportError, AttributeError, OSError, ValueError):
        resource: Any = importlib.import_module("resource")  # Windows has none
        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most != resource.RLIM_INFINITY:
            used = float(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
            free = min(free, most - used)
    return max(free, 1.0)


def free_disk(folder: Path) -> float:
    """Bytes that can still be written to the disk that a folder, or the nearest one above it, is on."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:
        return float(shutil.disk_usage(folder).free)
    except OSError:
        return math.inf
