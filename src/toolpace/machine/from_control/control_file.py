"""The text of a control's file, and the one error of what is wrong in it."""

from __future__ import annotations

import codecs
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from toolpace.common.errors import MachineError
from toolpace.common.files.atomic import reason
from toolpace.machine.plausibility import LONGEST_NAME

LARGEST = 32_000_000
"""Most bytes of a file: archives of a whole control have a few million."""
MOST_LINES = 500_000
"""Of a file: those archives have some ten thousand."""
LONGEST_LINE = 2000
"""Most characters of a line that is read."""
SHOWN = 60
"""Most characters of a line that a message quotes."""


class ControlFileError(MachineError):
    """A control's file that cannot be read, lacks what cannot be stood in for, or contradicts itself.

    The message is `file:line: what; cure`, without the line where it is about the whole file.
    """

    def __init__(self, message: str, *, file: str = "", line: int = 0) -> None:
        place = f"{file}:{line}: " if line else f"{file}: " if file else ""
        super().__init__(place + message)
        self.file, self.line = file, line


@dataclass(frozen=True)
class ControlFile:
    """A file as text; lines count from 1."""

    name: str
    """For messages and comments."""
    text: str
    folder: Path = Path()
    """In which it stands: names of other files in it count from there."""

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """Its lines, without their ends; of each the first LONGEST_LINE characters.

        LF CR CR is one end, with which Fanuc controls punch a block.
        """
        return tuple(line[:LONGEST_LINE] for line in self.text.replace("\n\r\r", "\n").splitlines())


def machine_name(file: ControlFile, control: str) -> str:
    """A name for a machine whose files have none: that of a file, else that of its control."""
    kept = "".join(letter if letter.isprintable() else " " for letter in Path(file.name).stem)[:LONGEST_NAME].strip()
    return kept or control


def load(path: Path, shown: str = "") -> ControlFile:
    """A file of text; `shown` is its name in messages. Raises ControlFileError.

    It is read once (it may be a pipe) and no further than a control's file can go (it may never end). Controls write
    UTF-8, or the code pages of Western Europe, in comments; editors also save UTF-16, which begins with a mark.
    """
    name = shown or str(path)
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        why = reason(error) if isinstance(error, OSError) else "no such name"
        raise ControlFileError(f"cannot be read ({why}); check the path", file=name) from None
    if len(data) > LARGEST:
        raise ControlFileError(f"has more than {LARGEST // 10**6} MB; give the control's files alone", file=name)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", errors="replace").encode()
    # a tape begins and ends with empty rows
    data = data.strip(b"\0")
    if b"\0" in data:
        raise ControlFileError("is not text; save it as text on the control (an archive in ASCII)", file=name)
    if data.count(b"\n") > MOST_LINES:
        raise ControlFileError(f"has more than {MOST_LINES} lines; give the control's files alone", file=name)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = (_without_parity(data) or data).decode("latin-1")
    return ControlFile(name, text, path.parent)


def _without_parity(data: bytes) -> bytes:
    """Letters of a tape in ISO code, whose eighth bit makes the number of bits even; empty where that is not so."""
    if any(letter.bit_count() % 2 for letter in set(data)):
        return b""
    return bytes(letter & 0x7F for letter in data)
