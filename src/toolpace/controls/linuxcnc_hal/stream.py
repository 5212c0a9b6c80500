"""The queue of rows between the component and LinuxCNC's `streamer`, which takes one each servo period."""

from __future__ import annotations

from typing import Any

from toolpace.common.errors import UsageError
from toolpace.controls.linuxcnc_hal.pins import JOINTS

CONFIG = "f" * JOINTS


class Rows:
    """Rows of joints [mm, deg] on their way to the realtime side."""

    def __init__(self, hal: Any, component: Any, key: int, ahead: int) -> None:
        """Attach to the streamer of a number, to be kept `ahead` rows full. Raises UsageError where there is none."""
        try:
            self._stream = hal.stream(component, hal.streamer_base + key, CONFIG)
        except Exception:  # of several kinds in hal
            raise UsageError(
                f"HAL has no streamer number {key} of {JOINTS} floats; before this, load it:"
                f" loadrt streamer depth=1000 cfg={CONFIG}"
            ) from None
        if self._stream.maxdepth <= ahead:
            raise UsageError(
                f"streamer number {key} holds {self._stream.maxdepth - 1} rows, the backlog is {ahead}; load it with"
                f" depth={2 * ahead}, or take a shorter --backlog"
            )
        self.ahead = ahead
        self.given = 0
        """Rows written so far."""
        self._dry = 0

    @property
    def depth(self) -> int:
        """Rows that wait."""
        return int(self._stream.depth)

    @property
    def room(self) -> int:
        """Rows that are missing."""
        return max(self.ahead - self.depth, 0)

    def write(self, row: list[float]) -> None:
        """Append a row."""
        self._stream.write(tuple(row))
        self.given += 1

    def count_from_here(self) -> None:
        """Periods without a row count from now on."""
        self._dry = int(self._stream.num_underruns)

    @property
    def late(self) -> int:
        """Servo periods that found no row."""
        return int(self._stream.num_underruns) - self._dry
