"""Block numbers in programs: N words, and the line numbers of Klartext."""

from __future__ import annotations

import re

import numpy as np

from toolpace.common.arrays import Ints
from toolpace.programs.reading.source import Source

_NUMBER = re.compile(
    r"[ \t]*+(?:/[0-9]?[ \t]*+(?=[N:])|/[ \t]*+)?(?:[N:][ \t]*+)?([0-9]{1,9})(?![0-9.])", re.IGNORECASE
)
"""At the head of a line, behind the slash of a block that may be passed over."""


def numbered_blocks(source: Source) -> Ints:
    """(k, 2) number and line, from 1, of each numbered block."""
    match = _NUMBER.match
    found = [(int(head[1]), line) for line, text in enumerate(source.lines, start=1) if (head := match(text))]
    return np.array(found, dtype=np.int64).reshape(-1, 2)
