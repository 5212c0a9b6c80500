"""The law of a follower as a file: the flat piece of kernels/follow/layout.py, nothing else."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from toolpace.arrays import Floats
from toolpace.errors import UsageError
from toolpace.files import reason, whole_file
from toolpace.kernels.follow import layout


def write_law(path: str | os.PathLike[str], piece: Floats) -> None:
    """Write a piece, little-endian, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(piece.astype("<f8").tobytes())


def read_law(path: str | os.PathLike[str]) -> Floats:
    """The piece in a file. Raises UsageError where it is none, of another version, or cut short."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: cannot read: {reason(error)}") from None
    piece = np.frombuffer(content[: len(content) // 8 * 8], dtype="<f8").astype(float)
    if len(piece) < layout.PATH or piece[layout.IS_PIECE] != layout.MAGIC:
        raise UsageError(f"{path}: no law of a follower; write one with Follower.save")
    if piece[layout.HAS_VERSION] != layout.VERSION:
        raise UsageError(
            f"{path}: a law of version {piece[layout.HAS_VERSION]:g}, read is {layout.VERSION:g}; write it anew"
        )
    samples, cells = piece[layout.SAMPLES], piece[layout.CELLS]
    wanted = layout.PATH + (samples + 3.0) * layout.COLUMNS + cells * layout.CELL_COLUMNS
    if not (
        8.0 * wanted == len(content) and samples >= 2.0 and cells >= 1.0 and np.isfinite(piece[: layout.HEAD]).any()
    ):
        raise UsageError(f"{path}: {len(content)} bytes where the law needs {8.0 * wanted:g}; write it anew")
    return piece
