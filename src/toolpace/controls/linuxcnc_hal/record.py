"""A record of the follower's output, row by row."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import reason
from toolpace.common.units import MILLIMETRE
from toolpace.controls.linuxcnc_hal.pins import JOINTS, Asked
from toolpace.deflection.following import SetPoint

COLUMNS = (
    "row", "t", *(f"joint_{j}" for j in range(JOINTS)), *(f"correction_{j}" for j in range(JOINTS)),
    "path_time", "pace", "deflection_x", "deflection_y", "deflection_z", "status",
)  # fmt: skip
"""row: number of the row in the queue; s, mm, deg; a deflection where one was counted on, else nan."""
BUFFER = 1 << 20
"""Bytes that are written at once, so that a disk is waited for seldom."""


class Record:
    """A file of set-points, or nothing where no file is asked for."""

    def __init__(self, file: Path | None) -> None:
        """Raises UsageError where the file cannot be written."""
        self._stream = None
        if file is not None:
            try:
                self._stream = file.open("w", encoding="utf-8", buffering=BUFFER)
            except OSError as error:
                raise UsageError(f"--record {file}: cannot write: {reason(error)}") from None
            self._stream.write(",".join(COLUMNS) + "\n")

    def __enter__(self) -> Record:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._stream is not None:
            self._stream.close()

    def write(self, row: int, joints: list[float], point: SetPoint, correction: Floats, asked: Asked | None) -> None:
        """One set-point: the row as it was given [mm, deg], and what it was made from."""
        if self._stream is None:
            return
        off = np.full(3, np.nan)
        if asked is not None and asked.deflection is not None:
            off = asked.deflection / MILLIMETRE
        figures = [point.t, *joints, *correction.tolist(), point.path_time, point.pace, *off.tolist()]
        self._stream.write(f"{row},{','.join(map(repr, figures))},{int(point.status)}\n")
