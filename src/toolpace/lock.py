"""A lock for functions that callers give, which can be copied and sent to other processes with them."""

from __future__ import annotations

import threading


class Lock:
    """Held while a caller's function runs: it may remember what it was asked last, and is not asked twice at once.

    A copy has a lock of its own.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def __reduce__(self) -> tuple[type[Lock], tuple[()]]:
        return Lock, ()
