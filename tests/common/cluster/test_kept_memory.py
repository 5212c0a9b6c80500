"""A worker keeps the memory of its last item."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

WORK = """
import resource, sys
import numpy as np
from toolpace.common.cluster.pool import keep_memory
if sys.argv[1] == "kept":
    assert keep_memory()
def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        np.ones(1_000_000).sum()
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
faults()
print(faults())
"""


def faults(how: str) -> int:
    """Pages that 20 arrays of 8 MB cost, one after the other, in a process set up as dask sets its workers up."""
    told = {**os.environ, "MALLOC_TRIM_THRESHOLD_": "65536"}
    ended = subprocess.run([sys.executable, "-c", WORK, how], env=told, capture_output=True, text=True, check=True)
    return int(ended.stdout)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="mallopt is of the GNU C library")
def test_arrays_of_the_next_item_lie_where_those_of_the_last_one_lay() -> None:
    """Without it each array costs its pages again: 8 MB are 2000 of them, or 4 large ones."""
    assert faults("kept") <= 5 < 80 <= faults("given back")
