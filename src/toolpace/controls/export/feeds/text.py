"""The lines of a program with their line ends, so that unchanged text stays identical."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

_ENDS = re.compile(r"(\r\n|\r|\n)")
_MARK = b"\xef\xbb\xbf"
"""Of UTF-8, which some editors put before the text."""


@dataclass(frozen=True)
class ProgramText:
    """Lines of a program, and what is needed to write them as they were."""

    lines: tuple[str, ...]
    """Without their ends."""
    ends: tuple[str, ...]
    """Of each line; empty where the last has none."""
    encoding: str
    marked: bool
    """Whether the mark of UTF-8 stands before it."""

    @classmethod
    def of(cls, data: bytes) -> ProgramText:
        """The text of a file: UTF-8, else one byte a character, as programs are read."""
        marked = data.startswith(_MARK)
        body = data.removeprefix(_MARK)
        encoding = "utf-8"
        try:
            text = body.decode(encoding)
        except UnicodeDecodeError:
            encoding = "latin-1"
            text = body.decode(encoding)
        parts = _ENDS.split(text)
        lines, ends = parts[::2], [*parts[1::2], ""]
        if len(lines) > 1 and not lines[-1]:
            lines.pop()
            ends.pop()
        return cls(tuple(lines), tuple(ends), encoding, marked)

    def with_lines(self, changed: Sequence[Sequence[str]]) -> bytes:
        """The file with each line replaced by one or more; those that are added end as the line does."""
        usual = next((end for end in self.ends if end), "\n")
        out: list[str] = []
        for lines, end in zip(changed, self.ends):
            out.append((end or usual).join(lines) + end)
        data = "".join(out).encode(self.encoding)
        return _MARK + data if self.marked else data
