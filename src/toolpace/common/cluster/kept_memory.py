"""Memory that a worker's process keeps for its next item, in place of giving it back to the system.

Workers of dask run with MALLOC_TRIM_THRESHOLD_=65536, which also fixes the size from which each array has pages of its
own: plans take and free arrays of some megabytes all the time, and a third of a worker's time went into pages that the
system clears and hands out again.
"""

from __future__ import annotations

import ctypes
import functools

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
"""Names of what is set, in <malloc.h> of the GNU C library."""
KEPT = 64_000_000
"""Free memory at the end of the heap up to which none is given back [bytes]."""
OWN_PAGES = 32_000_000
"""Size from which an array has pages of its own [bytes]; the library takes no more than 32 MiB."""


@functools.cache
def keep_memory() -> bool:
    """Keep it from now on; whether the C library of this process can."""
    try:
        set_option = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return False
    return bool(set_option(TRIM_THRESHOLD, KEPT)) and bool(set_option(MMAP_THRESHOLD, OWN_PAGES))
