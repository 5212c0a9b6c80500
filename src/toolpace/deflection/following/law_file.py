"""The law of a follower as a binary file."""

from __future__ import annotations

import os
import reprlib
import zlib
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import reason, whole_file
from toolpace.kernels.follow import layout


def write_law(path: str | os.PathLike[str], piece: Floats) -> None:
    """Write a piece, little-endian, with its checksum, whole or not at all."""
    written = piece.astype("<f8")
    written[layout.CHECKSUM] = checksum(piece)
    with whole_file(path) as temporary:
        temporary.write_bytes(written.tobytes())


def checksum(piece: Floats) -> float:
    """CRC-32 of a piece as it is in a file, with zeros in the checksum's own place."""
    summed = piece.astype("<f8")
    summed[layout.CHECKSUM] = 0.0
    return float(zlib.crc32(summed.tobytes()))


def read_law(path: str | os.PathLike[str]) -> Floats:
    """The piece in a file. Raises UsageError where it is none, of another version, cut short or changed."""
    if not isinstance(path, str | os.PathLike):
        raise UsageError(f"follower: {reprlib.repr(path)[:40]} is no path; give that of a file of Follower.save")
    if Path(path).is_dir():
        raise UsageError(f"{path}: a folder, not a law; Follower.from_folder takes the folder of a plan")
    try:
        content = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: cannot read: {reason(error)}") from None
    piece = np.frombuffer(content[: len(content) // 8 * 8], dtype="<f8").astype(float)
    if len(piece) < layout.PATH or piece[layout.IS_PIECE] != layout.MAGIC:
        raise UsageError(f"{path}: no law of a follower; write one with Follower.save")
    if piece[layout.HAS_VERSION] != layout.VERSION:
        raise UsageError(
            f"{path}: a law of version {piece[layout.HAS_VERSION]:g}, read is {layout.VERSION:g}; write it anew"
        )
    samples, cells = piece[layout.SAMPLES], piece[layout.CELLS]
    tools = layout.TOOL_COLUMNS * piece[layout.TOOLS]
    wanted = layout.PATH + (samples + 3.0) * layout.COLUMNS + cells * layout.CELL_COLUMNS + tools
    if 8.0 * wanted != len(content):
        raise UsageError(f"{path}: {len(content)} bytes where the law needs {8.0 * wanted:g}; write it anew")
    # Counts and indices lead the kernel through memory: no figure of a damaged file may get there.
    if piece[layout.CHECKSUM] != checksum(piece):
        raise UsageError(f"{path}: the law was changed since it was written (its checksum differs); write it anew")
    piece[layout.CHECKSUM] = 0.0
    if (fault := fault_of(piece)) is not None:
        raise UsageError(f"{path}: no follower can play this law: {fault}; write one with Follower.save")
    return piece


def fault_of(piece: Floats) -> str | None:
    """What makes no sense in a piece of the right size, or None: others than Follower.save may have written it."""
    if np.isnan(piece).any():
        return f"figure {int(np.isnan(piece).argmax())} is no number"
    for name, at in (("step", layout.STEP), ("cell", layout.CELL), ("period", layout.PERIOD)):
        if not 0.0 < piece[at] < np.inf:
            return f"its {name} is {piece[at]:g} s"
    if not (piece[layout.SAMPLES] >= 2.0 and piece[layout.CELLS] >= 1.0 and 0.0 <= piece[layout.DURATION] < np.inf):
        return "it has no path"
    if not piece[layout.TOOLS] >= 1.0:
        return "it has no tool"
    if not np.isfinite(piece[-int(piece[layout.TOOLS]) * layout.TOOL_COLUMNS :]).all():
        return "a tool of it has no length"
    if not (piece[layout.USED] in range(1, layout.JOINTS + 1) and piece[layout.DEAD_TIME] >= 0.0):
        return "its joints or its dead time make no sense"
    if not np.isfinite(piece[layout.PATH : layout.PATH + (int(piece[layout.SAMPLES]) + 3) * layout.COLUMNS]).all():
        return "its path leads to infinity"
    group = piece[layout.GROUP : layout.PLACE].view(np.int64)
    place = piece[layout.PLACE : layout.COMPLIANCE].view(np.int64)
    if not (np.isin(group, (0, 1, 2)).all() and np.array_equal(np.sort(place), np.arange(layout.JOINTS))):
        return "its joints are not five, in some order"
    return None
