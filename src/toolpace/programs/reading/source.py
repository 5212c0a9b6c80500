"""The text of a program by line, from a file, and its block numbers."""

from __future__ import annotations

import itertools
import os
import re
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, NoReturn

import numpy as np

from toolpace.common.arrays import Ints
from toolpace.common.errors import ProgramError, UsageError

ORDINARY_CONTROLS = frozenset(b"\t\n\v\f\r\x1a")
STANDARD_INPUT = ("-", "/dev/stdin")
"""What stands for it in place of a path."""
LARGEST = 1 << 30
"""Most bytes of a program: more is none, or would fill memory many times over before it is planned."""
PIECE = 1 << 24
"""Bytes that are read at a time: what is no program, and may never end, is told by the first."""
LONGEST_MESSAGE = 1500
"""Characters; of a message that is longer, since a word in it has no end, the middle is left out."""
MOST_NAMES = 2000
"""Files in a folder up to which one of a similar name is looked for."""
_NUMBER = re.compile(
    r"[ \t]*+(?:/[0-9]?[ \t]*+(?=[N:])|/[ \t]*+)?(?:[N:][ \t]*+)?([0-9]{1,9})(?![0-9.])", re.IGNORECASE
)
"""At the head of a line, behind the slash of a block that may be passed over."""


@dataclass(frozen=True)
class Source:
    """Lines of a program, numbered from 1, without their line ends."""

    name: str
    lines: tuple[str, ...]
    last_line_ended: bool
    """Whether the last line has a line end; where it has none the file may be cut off."""
    data: bytes = field(default=b"", repr=False)
    """The bytes of the file, read once; empty for text that came from elsewhere."""

    @staticmethod
    def from_text(text: str, name: str = "program") -> Source:
        """Split text at line ends only (a form feed or a Unicode separator ends no block)."""
        if not isinstance(text, str):
            cure = "tp.read(path) reads a file" if isinstance(text, os.PathLike) else "give text"
            raise UsageError(f"read_text: {type(text).__name__} in place of the text of a program; {cure}")
        if "\n" not in text and _is_file(text):
            raise UsageError(f"read_text: '{text[-60:]}' is the name of a file; tp.read(path) reads it")
        text = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\x1a")
        if not text.strip():
            raise ProgramError("the file is empty: nothing to plan; was it exported completely?", source=name)
        ended = text.endswith("\n")
        return Source(name, tuple(text[:-1].split("\n") if ended else text.split("\n")), ended)

    @staticmethod
    def load(path: str | Path) -> Source:
        """Read a file; ProgramError where it is missing, a folder, empty or not text."""
        if not isinstance(path, str | os.PathLike):
            raise UsageError(f"read: {type(path).__name__} in place of the path of a program")
        name = str(path)
        name = "standard input" if name in STANDARD_INPUT else name
        path = Path(path)
        try:
            data = _bytes(path, name)
        except FileNotFoundError:
            _refuse_text(name)
            near = _similar(path)
            hint = f"; did you mean {near}?" if near else "; check the path"
            raise ProgramError(f"no such file{hint}", source=name) from None
        except IsADirectoryError:
            raise ProgramError("this is a folder; name the program file in it", source=name) from None
        except (OSError, ValueError) as error:
            _refuse_text(name)
            reason = getattr(error, "strerror", None) or str(error)
            raise ProgramError(f"cannot be opened ({reason}); check the path and its rights", source=name) from None
        return Source.from_bytes(data, name)

    @staticmethod
    def from_bytes(data: bytes, name: str = "program") -> Source:
        """Decode bytes: UTF-8, else one byte a character, since old programs carry accents in comments."""
        controls = sum(data.count(code) for code in range(32) if code not in ORDINARY_CONTROLS)
        if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
            raise ProgramError("this is binary text (UTF-16); save it as plain text (UTF-8)", source=name)
        if b"\0" in data or controls > len(data) // 100:
            raise ProgramError("this is a binary file, not a program; export it as plain text (UTF-8)", source=name)
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
        return replace(Source.from_text(text, name), data=data)

    def must_be_ended(self, ends: str) -> None:
        """Raise a ProgramError where the last line has no line end; called where no word ended the program.

        ends: the words that could, as a list for people.
        """
        if not self.last_line_ended:
            self.fail(
                f"the program looks cut off: neither {ends} ends it, and its last line has no end; "
                "export it again, or end the line if it is complete",
                len(self.lines),
            )

    def fail(self, message: str, line: int, kind: type[ProgramError] = ProgramError) -> NoReturn:
        """Raise a ProgramError that shows the line (from 1; 0 speaks of the whole file)."""
        if line == len(self.lines) and not self.last_line_ended and "cut off" not in message:
            message += "; the file ends here without a line end: is it cut off?"
        if len(message) > LONGEST_MESSAGE:
            message = f"{message[: LONGEST_MESSAGE // 3]} ... {message[-LONGEST_MESSAGE // 3 :]}"
        text = self.lines[line - 1] if 0 < line <= len(self.lines) else ""
        shown = "".join(c if c.isprintable() else " " for c in text)
        raise kind(message, source=self.name, line=line, text=shown)


def _bytes(path: Path, name: str) -> bytes:
    """All bytes of a file, a pipe or a device, in one reading. Raises OSError, ValueError, ProgramError."""
    if name == "standard input":
        stream = getattr(sys.stdin, "buffer", None)
        if stream is None:
            raise OSError("closed")
        return _all_of(stream, name)
    with path.open("rb") as file:
        return _all_of(file, name)


def _all_of(stream: IO[bytes], name: str) -> bytes:
    pieces: list[bytes] = []
    while piece := stream.read(PIECE):
        pieces.append(piece)
        if sum(map(len, pieces)) > LARGEST or (len(piece) == PIECE and b"\0" in piece):
            Source.from_bytes(pieces[-1], name)
            raise ProgramError(f"the file has more than {LARGEST >> 30} GB; split the program", source=name)
    return b"".join(pieces)


def _similar(path: Path) -> str:
    import difflib

    try:
        names = [entry.name for entry in itertools.islice(path.parent.iterdir(), MOST_NAMES)]
    except OSError:
        return ""
    near = difflib.get_close_matches(path.name, names, n=1)
    return near[0] if near else ""


def _refuse_text(name: str) -> None:
    """Raise UsageError where a name that no file has is the text of a program."""
    if "\n" in name:
        raise UsageError("read: this is no path, but text; tp.read_text(text, machine) reads that of a program")


def _is_file(name: str) -> bool:
    """Whether a file has the name, also one that is too long for anything to have."""
    try:
        return Path(name).is_file()
    except (OSError, ValueError):
        return False


def numbered_blocks(source: Source) -> Ints:
    """(k, 2) number and line, from 1, of each numbered block."""
    match = _NUMBER.match
    found = [(int(head[1]), line) for line, text in enumerate(source.lines, start=1) if (head := match(text))]
    return np.array(found, dtype=np.int64).reshape(-1, 2)
