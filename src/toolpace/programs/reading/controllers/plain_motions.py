"""Plain motion blocks that all controls read alike."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter

from toolpace.programs.reading.source import Source

PLAIN = re.compile(
    r"[ \t]*+(N\d++)?((?:[ \t]*+(?:G0?[0-3](?![\d.])|[XYZABCIJKF][-+]?[\d.]++))*+)[ \t]*+;?+", re.IGNORECASE
)
"""A block of plain words: its number, and the words."""
_LETTERS = re.compile(r"G0?[0-3]|F[-+]?[\d.]++|[A-Z]", re.IGNORECASE)
_JUMPS = re.compile(r"GOTO|M9[789]", re.IGNORECASE)
"""Words that go to numbers of blocks."""
KEPT = 3
"""Blocks of the same words that are kept of those between two that are not plain."""


def thinned(source: Source) -> Source:
    """The program without most plain straight motions, its lines at their numbers.

    Between two blocks that are not plain motions, the first of each kind are kept: the same letters, G and F. Arcs are
    plain, but all kept. What controls read differently they read differently in these too, but for what depends
    on figures of straight motions alone.
    """
    jumps = any(map(_JUMPS.search, source.lines))
    seen: Counter[tuple[str, ...]] = Counter()
    lines = []
    for line in source.lines:
        plain = PLAIN.fullmatch(line)
        if plain is None:
            seen.clear()
        elif plain[2]:
            kind = tuple(_LETTERS.findall(plain[2]))
            seen[kind] += 1
            if seen[kind] > KEPT and not {"I", "J", "K"} & set(kind):
                lines.append((plain[1] or "") if jumps else "")
                continue
        lines.append(line)
    return dataclasses.replace(source, lines=tuple(lines), data=b"")
