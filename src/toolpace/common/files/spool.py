"""Objects put aside on the disk while others are worked on: memory stays as it is however many there are."""

from __future__ import annotations

import pickle
import tempfile
import threading
import weakref
from typing import Any

from toolpace.common.errors import UsageError
from toolpace.common.files.atomic import reason

IN_MEMORY = 1 << 25
"""Bytes that are kept in memory; beyond, all go to a file without a name in the system's temporary folder."""


class Spool:
    """Objects by number, in any order and from any thread. The file is gone with the spool, however the process ends.

    Raises UsageError where the disk is full.
    """

    def __init__(self) -> None:
        self._file = tempfile.SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115
        weakref.finalize(self, self._file.close)
        self._places: dict[int, tuple[int, int]] = {}
        self._end = 0
        self._lock = threading.Lock()

    def __contains__(self, number: int) -> bool:
        return number in self._places

    def put(self, number: int, value: Any) -> None:
        """Put an object aside that can be pickled."""
        data = pickle.dumps(value, pickle.HIGHEST_PROTOCOL)
        with self._lock:
            try:
                self._file.seek(self._end)
                self._file.write(data)
            except OSError as error:
                raise UsageError(
                    f"temporary folder {tempfile.gettempdir()}: cannot write: {reason(error)}; free some space there, "
                    "or name another one in TMPDIR"
                ) from None
            self._places[number] = self._end, len(data)
            self._end += len(data)

    def get(self, number: int) -> Any:
        """The object of a number. Raises KeyError where there is none."""
        place, size = self._places[number]
        with self._lock:
            self._file.seek(place)
            data = self._file.read(size)
        return pickle.loads(data)

    def numbers(self) -> list[int]:
        """All numbers, in their order."""
        return sorted(self._places)
