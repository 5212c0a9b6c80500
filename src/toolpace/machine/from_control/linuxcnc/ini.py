"""The entries of LinuxCNC's INI, with the files that it includes, each with its file and line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from toolpace.machine.from_control.control_file import SHOWN, ControlFile, ControlFileError, load
from toolpace.machine.from_control.record import Figure, Origin

DEEPEST = 16
"""Includes within includes, as LinuxCNC itself allows."""
MOST_INCLUDES = 200
"""In all: a few files that include each other often would never end."""
MOST_LINES = 100_000
"""Of an INI with its includes, and of a HAL file: they have a few hundred."""
_HEADING = re.compile(r"\s*\[([^\]]*)\]")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_COMMENT = re.compile(r"\s[#;].*")


@dataclass(frozen=True)
class Entry:
    """One `KEY = value`."""

    text: str
    origin: Origin

    def figure(self) -> Figure:
        """Its number. Raises ControlFileError where it is none."""
        number = _NUMBER.match(self.text)
        rest = self.text[number.end() :].strip() if number else ""
        if number is None or (rest and rest[0] not in "#;"):
            raise self.origin.no_number(self.text)
        value = float(number.group())
        if math.isinf(value):
            raise self.origin.error(f"= {number.group()[:SHOWN]} is too large to be a number; correct it")
        return Figure(value, (self.origin,))

    def word(self) -> str:
        """Its text without a comment behind it."""
        return _COMMENT.sub("", self.text).strip()


@dataclass
class Ini:
    """Entries by section and key, in their order."""

    file: ControlFile
    entries: dict[tuple[str, str], list[Entry]] = field(default_factory=dict)
    files: list[str] = field(default_factory=list)
    """Names of all that were read."""

    def all(self, section: str, key: str) -> Sequence[Entry]:
        """Every entry of a key that may stand often."""
        return self.entries.get((section, key), ())

    def entry(self, section: str, key: str) -> Entry | None:
        """The entry of a key that stands once. Raises ControlFileError where it stands twice with two meanings."""
        found = self.all(section, key)
        for other in found[1:]:
            if other.word() != found[0].word():
                raise other.origin.error(
                    f"= '{other.word()[:SHOWN]}' contradicts {found[0].origin} = '{found[0].word()[:SHOWN]}'; "
                    "remove one of both lines"
                )
        return found[0] if found else None

    def figure(self, section: str, key: str) -> Figure | None:
        """The number of a key, if it is there. Raises ControlFileError."""
        entry = self.entry(section, key)
        return None if entry is None else entry.figure()

    def word(self, section: str, key: str) -> str:
        """The word of a key; empty where it is not there."""
        entry = self.entry(section, key)
        return "" if entry is None else entry.word()

    def sections(self) -> list[str]:
        """Names of the sections, each once."""
        return list(dict.fromkeys(section for section, _ in self.entries))


def read_ini(file: ControlFile, beside: Sequence[ControlFile] = ()) -> Ini:
    """The entries of an INI and of what it includes; `beside` are files that were given with it, by their names.

    Raises ControlFileError.
    """
    ini = Ini(file, files=[file.name])
    section = ""
    for count, (origin, line) in enumerate(_included(ini, file, beside, (file.name,))):
        if count > MOST_LINES:
            raise ControlFileError(f"has more than {MOST_LINES} lines: this is no INI", file=file.name)
        text = line.strip()
        if not text or text[0] in "#;":
            continue
        if heading := _HEADING.match(line):
            section = heading.group(1).strip()
            continue
        key, sign, value = text.partition("=")
        if sign and section:
            name = key.strip()
            place = Origin(f"[{section}] {name[:SHOWN]}", origin.file, origin.line)
            ini.entries.setdefault((section, name), []).append(Entry(value.strip(), place))
    return ini


def _included(
    ini: Ini, file: ControlFile, beside: Sequence[ControlFile], above: tuple[str, ...]
) -> Iterator[tuple[Origin, str]]:
    """The lines of a file, in place of an include those of the file that it names, with where they stand."""
    pending = ""
    for number, line in enumerate(file.lines, 1):
        origin = Origin("#INCLUDE", file.name, number)
        if line.startswith("#INCLUDE ") and not pending:
            name = line[len("#INCLUDE ") :].strip()
            inner = found_file(name, ini.file, beside) if name else None
            if inner is None:
                raise origin.error(f"{name[:SHOWN] or 'a file without a name'} is not there; copy it beside the INI")
            if inner.name in above or len(above) >= DEEPEST:
                raise origin.error(f"{inner.name} goes round in a circle, or deeper than {DEEPEST} files; remove it")
            ini.files.append(inner.name)
            if len(ini.files) > MOST_INCLUDES:
                raise origin.error(f"is one of more than {MOST_INCLUDES}; remove what is not needed")
            yield from _included(ini, inner, beside, (*above, inner.name))
        elif line.endswith("\\") and not line.lstrip().startswith(("#", ";")):
            pending += line[:-1]
        else:
            yield origin, pending + line
            pending = ""
    if pending:
        yield Origin("", file.name, len(file.lines)), pending


def found_file(name: str, ini: ControlFile, beside: Sequence[ControlFile]) -> ControlFile | None:
    """A file that an INI names: one that was given with it, or that stands in its place. None where it is not there."""
    for other in beside:
        if Path(other.name).name == Path(name).name:
            return other
    try:
        path = Path(name).expanduser()
        path = path if path.is_absolute() else ini.folder / path
        there = path.is_file()
    except (OSError, ValueError, RuntimeError):
        return None
    if not there:
        return None
    shown = str(Path(ini.name).parent / name) if not Path(name).is_absolute() else name
    return load(path, shown)


def check_is_new(ini: Ini) -> None:
    """Refuse an INI of LinuxCNC 2.7 and before, whose [AXIS_0] are joints. Raises ControlFileError."""
    for (section, _), entries in ini.entries.items():
        if re.fullmatch(r"AXIS_\d+", section):
            raise ControlFileError(
                f"[{section}] is of LinuxCNC 2.7 or before; run its `update_ini` on the file",
                file=entries[0].origin.file, line=entries[0].origin.line,
            )  # fmt: skip
