"""The text of a program and its name: what every dialect reads from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from toolpace.errors import ProgramError

ORDINARY_CONTROLS = frozenset(b"\t\n\v\f\r\x1a")


@dataclass(frozen=True)
class Source:
    """Lines of a program, numbered from 1, without their line ends."""

    name: str
    lines: tuple[str, ...]
    last_line_ended: bool
    """Whether the last line has a line end; where it has none the file may be cut off."""

    @staticmethod
    def from_text(text: str, name: str = "program") -> Source:
        """Split text at line ends only (a form feed or a Unicode separator ends no block)."""
        text = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\x1a")
        if not text.strip():
            raise ProgramError("the file is empty: nothing to plan; was it exported completely?", source=name)
        ended = text.endswith("\n")
        return Source(name, tuple(text[:-1].split("\n") if ended else text.split("\n")), ended)

    @staticmethod
    def load(path: str | Path) -> Source:
        """Read a file; ProgramError where it is missing, a folder, empty or not text."""
        path, name = Path(path), str(path)
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            near = _similar(path)
            hint = f"; did you mean {near}?" if near else "; check the path"
            raise ProgramError(f"no such file{hint}", source=name) from None
        except IsADirectoryError:
            raise ProgramError("this is a folder; name the program file in it", source=name) from None
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ProgramError(f"cannot be opened ({reason}); check the path and its rights", source=name) from None
        return Source.from_bytes(data, name)

    @staticmethod
    def from_bytes(data: bytes, name: str = "program") -> Source:
        """Decode bytes: UTF-8, else one byte a character, since old programs carry accents in comments."""
        controls = sum(data.count(code) for code in range(32) if code not in ORDINARY_CONTROLS)
        if b"\0" in data or controls > len(data) // 100:
            raise ProgramError("this is a binary file, not a program; export it as plain text (UTF-8)", source=name)
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
        return Source.from_text(text, name)

    def fail(self, message: str, line: int) -> NoReturn:
        """Raise a ProgramError that shows the line (from 1; 0 speaks of the whole file)."""
        if line == len(self.lines) and not self.last_line_ended and "cut off" not in message:
            message += "; the file ends here without a line end: is it cut off?"
        text = self.lines[line - 1] if 0 < line <= len(self.lines) else ""
        shown = "".join(c if c.isprintable() else " " for c in text)
        raise ProgramError(message, source=self.name, line=line, text=shown)


def _similar(path: Path) -> str:
    import difflib

    try:
        names = [entry.name for entry in path.parent.iterdir()]
    except OSError:
        return ""
    near = difflib.get_close_matches(path.name, names, n=1)
    return near[0] if near else ""
