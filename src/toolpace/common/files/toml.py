"""Tables from TOML files that people write, every error with the file's name; and TOML text from tables, exact."""

from __future__ import annotations

import io
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NoReturn

from toolpace.common.errors import ToolpaceError, UsageError, did_you_mean, in_short
from toolpace.common.files.atomic import reason

BYTES = 4
"""Most that a character takes (UTF-8)."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class TableFile:
    """A kind of file: what messages call it, how long it may be, and what is raised where it is wrong."""

    name: str
    longest: int
    """[characters]"""
    error: type[ToolpaceError] = UsageError

    def data(self, path: str | Path) -> bytes:
        """What a file holds, read once (it may be a pipe) and no further than one can go (it may never end)."""
        try:
            with Path(path).open("rb") as stream:
                return stream.read(BYTES * self.longest + 1)
        except (OSError, ValueError) as error:
            why = reason(error) if isinstance(error, OSError) else "no such name"
            raise self.error(f"{self.name} {path}: cannot be read ({why}); check the path") from None

    def text_of(self, data: bytes, source: str) -> str:
        """The text that it is; `source` names the file in messages."""
        if len(data) > BYTES * self.longest:
            raise self._too_long(source)
        try:
            return io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig").read()
        except UnicodeDecodeError:
            raise self.error(f"{self.name} {source}: not a text file; save it as UTF-8") from None

    def text(self, path: str | Path) -> str:
        """The text of a file."""
        return self.text_of(self.data(path), str(path))

    def table(self, text: str, source: str, parse_float: Callable[[str], float] = float) -> dict[str, Any]:
        """The table that a text is; `source` names the file in messages."""
        if len(text) > self.longest:
            raise self._too_long(source)
        try:
            return tomllib.loads(text, parse_float=parse_float)
        except RecursionError:
            raise self.error(f"{source}: not a {self.name}: tables or arrays lie too deep in each other") from None
        except ValueError as error:
            # Of a number of thousands of digits Python says how a program may allow it, which helps nobody here.
            why = in_short(error).partition("; use sys.")[0]
            raise self.error(f"{source}: not a TOML file: {why}") from None

    def _too_long(self, source: str) -> ToolpaceError:
        return self.error(f"{source}: has more than {self.longest} characters: this is no {self.name}")


class Tables:
    """One reading of the tables of a file; every error names the file, and the place in it."""

    longest: ClassVar[int] = 500
    """Most characters of an error."""

    def __init__(self, source: str, raw: Mapping[str, Any]) -> None:
        self.source, self.raw = source, raw

    def fail(self, place: str, what: str) -> NoReturn:
        """Raise UsageError: what is wrong at a place, and how to cure it."""
        raise UsageError(f"{self.source}: {place} {what}"[: self.longest])

    def refuse_unknown_keys(self, place: str, table: Mapping[str, object], names: tuple[str, ...]) -> None:
        """Refuse keys that mean nothing there."""
        for key in table:
            if key not in names:
                self.fail(place, f"has the unknown key '{key[:40]}'; {did_you_mean(key, names)}")

    def table(self, name: str) -> dict[str, Any]:
        """The table under a heading; an empty one where it is not there."""
        found = self.raw.get(name, {})
        if not isinstance(found, dict):
            self.fail(name, f"= {found!r:.40} is not a table; write it under the heading [{name}]")
        return found


def toml_text(table: Mapping[str, Any], above: str = "") -> str:
    """The text of a table: numbers, words and lists of them first, then the tables in it under their headings.

    above: heading of the table itself, where it stands in another.
    """
    text = "\n".join(_lines(table, above)).strip("\n")
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def _lines(table: Mapping[str, Any], above: str, headed: bool = False) -> list[str]:
    """headed: whether the heading of the table itself stands there already, as that of one in a list does."""
    inner = {key: value for key, value in table.items() if _is_table(value) or _is_tables(value)}
    lines = [f"{toml_key(key)} = {toml_value(value)}" for key, value in table.items() if key not in inner]
    if above and not headed and (lines or not inner):
        lines = [f"[{above}]", *lines]
    for key, value in inner.items():
        heading = f"{above}.{toml_key(key)}" if above else toml_key(key)
        if _is_table(value):
            lines += ["", *_lines(value, heading)]
            continue
        for each in value:
            lines += ["", f"[[{heading}]]", *_lines(each, heading, headed=True)]
    return lines


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping)


def _is_tables(value: object) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(_is_table(each) for each in value)


def toml_key(key: str) -> str:
    """A key as it is written: in quotes where it must be."""
    return key if _BARE.fullmatch(key) else toml_value(key)


def toml_value(value: bool | str | float | Sequence[Any]) -> str:
    """A word in quotes, a number, or a list of them; what cannot be printed is written as its number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
    if isinstance(value, (int, float)):
        return repr(value)
    return "[" + ", ".join(map(toml_value, value)) + "]"
