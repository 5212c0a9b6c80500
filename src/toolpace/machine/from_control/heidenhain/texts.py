"""The three kinds of text that a Heidenhain control keeps a machine in, each value with its file and line.

* Machine parameters of the iTNC 530: `MP1010.0 : 30000 ; comment` (Technical Manual iTNC 530 HSCI, page 571).
* Its kinematics tables, with columns KEY, AXIS and COORD (the same, pages 670 and 722).
* Configuration objects of the TNC 320 to 640, `CfgFeedLimits( key:="X", rapidFeed:=30000, ... )`, with comments behind
  `--` and between `(*` and `*)` (Technical Manual MANUALplus 620, chapter 4.6, page 380).
"""

from __future__ import annotations

import bisect
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from toolpace.machine.from_control.control_file import SHOWN, ControlFile, ControlFileError
from toolpace.machine.from_control.record import Figure, Origin

MOST_LINES = 200_000
"""Of one file."""
MOST_OBJECTS = 20_000
"""Of all files: a control has some thousand."""
ATTRIBUTES = frozenset({
    "key", "rapidFeed", "maxAcceleration", "axPathJerk", "axPathJerkHi", "swLimitSwitchPos", "swLimitSwitchNeg",
    "isModulo", "maxPathJerk", "maxPathJerkHi", "maxG1Feed", "minPathFeed", "minCornerFeed", "subKinList", "kinObjects",
    "dir", "val", "axisRef", "axesToolSide", "trafoToolSide", "toolCoordSys", "axesWpSide", "trafoWpSide",
    "machineTableSys", "location", "zDir", "xDir", "angle1", "angle2", "angle3",
})  # fmt: skip
"""Attributes of configuration objects that are read; all others are passed over."""
_ATTRIBUTE_NAMES = {name.lower(): name for name in ATTRIBUTES}
PARAMETER = re.compile(
    r"\s*MP\s*_?(\d{1,5})(?:\.(\d{1,2}))?\s*[:=]\s*([^;\s]+)\s*((?:(?!//|--)[^;(#*])*)", re.IGNORECASE
)
NEARLY = re.compile(r"\s*MP\s*_?\d", re.IGNORECASE)
"""The beginning of what should be a parameter."""
TABLE_HEADING = re.compile(r"\s*NR\s+(?:\S+\s+)*?KEY\s+AXIS\s+COORD\b", re.IGNORECASE)
KEYS = frozenset({"trans", "machaxis", "machbase", "toolaxis"})
"""Of rows of a kinematics table that are read, in lower case."""
OBJECT = re.compile(r"\b(Cfg\w{1,60})\s*+\(", re.ASCII)
_ROW = re.compile(r"\s*+\d++\s++([A-Za-z]\w*+)((?:\s++\S++)*+)\s*+$")
_COMMENT = re.compile(r"\(\*(?:[^*]++|\*(?!\)))*+(?:\*\)|\Z)|--[^\n]*+")
_ATTRIBUTE = re.compile(r"\s*+,?\s*+(\w{1,60})\s*+:=\s*+(\[[^\]]*\]|\"[^\"\n]*\"|\([^()]*\)|[^\s,()\[\]\"]+)", re.ASCII)
_BLANKS = re.compile(r"\s*+")
_NUMBER = re.compile(r"[-+]?(?:\d{1,30}(?:[.,]\d{0,30})?|[.,]\d{1,30})(?:[eE][-+]?\d{1,3})?")


@dataclass(frozen=True)
class Entry:
    """One value as it stands in a file, without quotes; a list with commas between its elements."""

    text: str
    origin: Origin
    behind: str = ""
    """What stands between the value and a comment."""

    def figure(self) -> Figure:
        """Its number. Raises ControlFileError where it is none, or not all that there is."""
        if self.behind:
            raise self.origin.error(
                f"= {self.text[:SHOWN]} has '{self.behind[:SHOWN]}' behind it; give the number alone, in the control's "
                "unit"
            )
        value = float(self.text.replace(",", ".")) if _NUMBER.fullmatch(self.text) else math.nan
        if not math.isfinite(value):
            raise self.origin.no_number(self.text)
        return Figure(value, (self.origin,))

    def elements(self) -> list[str]:
        """The elements of a list, without quotes."""
        return [part.strip().strip('"') for part in self.text.strip("[]").split(",") if part.strip()]

    @property
    def is_true(self) -> bool:
        """Of a value that is TRUE or FALSE."""
        return self.text.upper() == "TRUE"


@dataclass(frozen=True)
class ConfigurationObject:
    """A parameter object with its attributes."""

    kind: str
    """As `CfgFeedLimits`."""
    key: str
    origin: Origin
    attributes: dict[str, Entry]


@dataclass(frozen=True)
class Row:
    """A row of a kinematics table."""

    key: str
    """In lower case."""
    axis: str
    coordinate: Entry | None
    origin: Origin


@dataclass
class Texts:
    """All that files have."""

    parameters: dict[tuple[int, int], Entry] = field(default_factory=dict)
    """By number and index; index 0 where it has none."""
    by_name: dict[tuple[str, str], ConfigurationObject] = field(default_factory=dict)
    """Configuration objects by kind and key."""
    rows: list[Row] = field(default_factory=list)
    table: str = ""
    """Name of the file with the kinematics table."""
    inch_table: Origin | None = None
    """Where the table says that its lengths are inches."""
    strange: list[Origin] = field(default_factory=list)
    """Lines that begin as a parameter does and have no value."""
    table_ends: bool = True
    """Whether the table ends with [END]."""

    @property
    def objects(self) -> list[ConfigurationObject]:
        """All configuration objects, in their order."""
        return list(self.by_name.values())


def kind_of(file: ControlFile) -> str:
    """"table", "objects" or "parameters"; empty for a text of none of them."""
    if any(TABLE_HEADING.match(line) for line in file.lines[:20]):
        return "table"
    if OBJECT.search(file.text) and ":=" in file.text:
        return "objects"
    return "parameters" if sum(PARAMETER.match(line) is not None for line in file.lines) >= 2 else ""


def read_texts(texts: Texts, file: ControlFile) -> None:
    """Add what a file has. Raises ControlFileError for a file of another kind, and for two unlike values."""
    if len(file.lines) > MOST_LINES:
        raise ControlFileError(f"has more than {MOST_LINES} lines: this is no file of a Heidenhain", file=file.name)
    kind = kind_of(file)
    if kind == "table":
        _read_table(texts, file)
    elif kind == "objects":
        for each in _objects(file):
            _keep_object(texts, each)
    elif kind == "parameters":
        _read_parameters(texts, file)
    else:
        raise ControlFileError(
            "has neither machine parameters, nor configuration objects, nor a kinematics table; leave it out",
            file=file.name,
        )


def _read_parameters(texts: Texts, file: ControlFile) -> None:
    for number, line in enumerate(file.lines, 1):
        if match := PARAMETER.match(line):
            index = f".{match[2]}" if match[2] is not None else ""
            entry = Entry(match[3], Origin(f"MP{match[1]}{index}", file.name, number), match[4].strip())
            first = texts.parameters.setdefault((int(match[1]), int(match[2] or 0)), entry)
            if first.text != entry.text:
                raise entry.origin.error(
                    f"= {entry.text[:SHOWN]} contradicts {first.origin} = {first.text[:SHOWN]}; remove one of both"
                )
        elif NEARLY.match(line):
            texts.strange.append(Origin(f"'{line.strip()[:SHOWN]}'", file.name, number))


def _read_table(texts: Texts, file: ControlFile) -> None:
    if texts.table:
        raise ControlFileError(f"is a second kinematics table beside {texts.table}; give that in force", file=file.name)
    texts.table = file.name
    rows = False
    texts.table_ends = False
    for number, line in enumerate(file.lines, 1):
        words = line.split()
        if not rows:
            if words[:1] == ["BEGIN"] and "INCH" in words:
                texts.inch_table = Origin("BEGIN ... INCH", file.name, number)
            rows = TABLE_HEADING.match(line) is not None
        elif words and words[0].upper() == "[END]":
            texts.table_ends = True
            return
        elif match := _ROW.match(line):
            cells = match[2].split()
            axis = cells.pop(0) if cells and re.fullmatch(r"[A-Za-z]", cells[0]) else ""
            name = f"{match[1]} {axis}".strip()
            origin = Origin(name[:SHOWN], file.name, number)
            coordinate = Entry(cells[0], origin) if cells else None
            texts.rows.append(Row(match[1].lower(), axis.upper(), coordinate, origin))
        elif KEYS & {word.lower() for word in words} and not words[0].startswith((";", "#", "*")):
            raise Origin(" ".join(words)[:SHOWN], file.name, number).error(
                "is no row with NR, KEY, AXIS and COORD: it has no line number; correct it"
            )


def _objects(file: ControlFile) -> Iterator[ConfigurationObject]:
    """The parameter objects of a text. Raises ControlFileError where one does not end."""
    starts = [0, *(match.end() for match in re.finditer("\n", file.text))]
    # comments go, lines and places stay
    text = _COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), file.text)
    for found in OBJECT.finditer(text):
        attributes: dict[str, Entry] = {}
        place = found.end()
        while match := _ATTRIBUTE.match(text, place):
            if (name := _ATTRIBUTE_NAMES.get(match[1].lower())) is not None:
                line = bisect.bisect_right(starts, match.start(1))
                origin = Origin(f"{found[1]} {name}", file.name, line)
                attributes[name] = Entry(match[2].strip('"'), origin)
            place = match.end()
        line = bisect.bisect_right(starts, found.start())
        origin = Origin(found[1], file.name, line)
        end = _BLANKS.match(text, place)
        place = place if end is None else end.end()
        if not text.startswith(")", place):
            rest = " ".join(text[place : place + SHOWN].split()) or "the end of the file"
            raise origin.error(f"has '{rest}' where an attribute or its end was expected; is the file whole?")
        key = attributes.pop("key", None)
        named = "" if key is None else key.text
        label = f"{found[1]} {named}".strip()[:SHOWN]
        yield ConfigurationObject(
            found[1], named, Origin(label, file.name, line),
            {name: Entry(entry.text, Origin(f"{label} {name}", file.name, entry.origin.line))
             for name, entry in attributes.items()},
        )  # fmt: skip


def _keep_object(texts: Texts, new: ConfigurationObject) -> None:
    """Keep an object; the control refuses a second one of the same name and key too."""
    other = texts.by_name.setdefault((new.kind, new.key), new)
    if other is not new:
        raise new.origin.error(f"is there twice, as {other.origin}; remove one of both")
    if len(texts.by_name) > MOST_OBJECTS:
        raise new.origin.error(f"is one of more than {MOST_OBJECTS} objects: give the files of one control alone")
