"""Times of operations as a shop writes them down, in a text or a table (CSV) of any spreadsheet.

A line is an operation and its time:

    Face the top, 1:23
    "Pocket, rough"; 2 min 5 s
    Drill        83.4 s
    total        6:10

A time is minutes and seconds (1:23), hours too (1:02:03), or figures with their units (h, min, s). How exact it is
follows from its last digit: 1:23 to a second, 83.4 s to a tenth, 2 min to a minute. A heading may have the unit of its
column: `Operation;Time [s]`.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from toolpace.common.errors import UsageError, printable
from toolpace.common.files import reason

TOTAL = ("", "total", "all", "program", "sum", "gesamt", "summe")
"""Names of the whole program."""
LONGEST = 1e7
"""[s]: a longer time is a slip."""
LONGEST_LINE = 1000
"""Characters of a line with a time: looking for a time takes as long as their square."""
HOUR, MINUTE = 3600.0, 60.0
_FIGURE = r"\d+(?:[.,]\d+)?"
_HOUR, _MINUTE, _SECOND = r"h(?:ours?)?", r"m(?:in(?:utes?)?)?\.?", r"s(?:e[ck](?:onds?)?)?\.?"
_CLOCK = re.compile(r"(?:(?P<h>\d+):)?(?P<min>\d+):(?P<s>[0-5]\d(?:[.,]\d+)?)")
_UNITS = re.compile(
    rf"(?:(?P<h>{_FIGURE})\s*{_HOUR})?\s*(?:(?P<min>{_FIGURE})\s*{_MINUTE})?\s*(?:(?P<s>{_FIGURE})\s*{_SECOND})?",
    re.IGNORECASE,
)
_TIME_AT_END = re.compile(
    rf"(?P<time>(?:\d+:)?\d+:\d\d(?:[.,]\d+)?|{_FIGURE}\s*(?:{_HOUR}|{_MINUTE}|{_SECOND})"
    rf"(?:\s*{_FIGURE}\s*(?:{_MINUTE}|{_SECOND})){{0,2}})\s*[;,]*\s*$",
    re.IGNORECASE,
)
_UNIT_OF_COLUMN = re.compile(rf"[\[(]\s*(?P<unit>{_HOUR}|{_MINUTE}|{_SECOND})\s*[\])]", re.IGNORECASE)


@dataclass(frozen=True)
class WrittenTime:
    """A time that was written down."""

    operation: str
    """Empty of the whole program."""
    seconds: float
    resolution: float
    """Unit of the last digit that is written [s]."""

    @property
    def deviation(self) -> float:
        """Standard deviation of what was left out by rounding [s]."""
        return self.resolution / math.sqrt(12.0)


def written_time(text: str, operation: str = "") -> WrittenTime | None:
    """The time that a text is: `1:23`, `83 s`, `2 min`; None where it is none."""
    words = text.strip()
    found = _CLOCK.fullmatch(words) or _UNITS.fullmatch(words)
    if found is None or not words:
        return None
    seconds, resolution = 0.0, math.inf
    for name, unit in (("h", HOUR), ("min", MINUTE), ("s", 1.0)):
        if (figure := found[name]) is not None:
            figure = figure.replace(",", ".")
            seconds += float(figure) * unit
            resolution = unit * 10.0 ** -len(figure.partition(".")[2])
    return WrittenTime(operation, seconds, resolution) if 0.0 < seconds < LONGEST else None


def load_written_times(path: str | Path) -> list[WrittenTime]:
    """The times of a file (text or CSV). Raises UsageError naming file, line and cure."""
    found: list[WrittenTime] = []
    units: Mapping[int, str] = {}
    columns = 0
    for number, line in enumerate(_text(path).splitlines(), start=1):
        words = line.partition("#")[0].strip()
        if not words.strip('"\';,\t') or words.lower().startswith("sep="):
            continue
        if not found and not any(map(str.isdigit, words)):
            heading = _cells(words)
            columns = len(heading)
            units = {k: unit["unit"] for k, cell in enumerate(heading) if (unit := _UNIT_OF_COLUMN.search(cell))}
            continue
        where = f"--fit {path}:{number}: '{printable(words[:60])}'"
        found.append(_of_line(words, units, columns, where))
    if not found:
        raise UsageError(f"--fit {path}: there is no time in it; write an operation and its time: Pocket, 1:23")
    return found


def _text(path: str | Path) -> str:
    """A file in UTF-8, or as spreadsheets write it: UTF-16 with its mark, or a code page of one byte a letter."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        cure = "check the path, or give one time, such as 3:12 or 83 s"
        raise UsageError(f"--fit {path}: cannot be read ({reason(error)}); {cure}") from None
    for encoding in ("utf-16",) if data.startswith((b"\xff\xfe", b"\xfe\xff")) else ("utf-8-sig", "latin-1"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise UsageError(f"--fit {path}: no text; save it as text or CSV")


def _of_line(words: str, units: Mapping[int, str], columns: int, where: str) -> WrittenTime:
    """The time of a line; `where` begins its errors."""
    cells = _cells(words) if len(words) <= LONGEST_LINE else []
    in_columns = len(cells) > 1 and (bool(units) or any(each in words for each in ';\t"'))
    # a figure with a decimal comma between commas is two cells
    if in_columns and not (units and len(cells) != columns):
        times = {
            k: time
            for k, cell in enumerate(cells)
            if (time := written_time(cell) or written_time(cell + units.get(k, "")))
        }
        if len(times) > 1:
            raise UsageError(f"{where} has {len(times)} times; leave one in each line")
        for column, time in times.items():
            return _named(_first_word([*cells[:column], *cells[column + 1 :]]), time)
    at_end = _TIME_AT_END.search(words) if len(words) <= LONGEST_LINE else None
    found = None if at_end is None else written_time(at_end["time"])
    if at_end is None or found is None:
        raise UsageError(
            f"{where} ends with no time; write an operation and its time, such as: Pocket, 1:23 (or 83 s, 2 min 5 s). "
            "A log of the axes begins with a line that names its columns: t and the joints"
        )
    before = words[: at_end.start()]
    if before.endswith("-"):
        raise UsageError(f"{where} is below zero; write it without -")
    return _named(before.rstrip(",;:=- \t").strip().strip("\"'").strip(), found)


def _named(name: str, time: WrittenTime) -> WrittenTime:
    return WrittenTime("" if name.lower() in TOTAL else name, time.seconds, time.resolution)


def _cells(line: str) -> list[str]:
    """The cells of a line of a table: between semicolons or tabs, where it has any, else between commas."""
    separator = next((each for each in ";\t" if each in line), ",")
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _first_word(cells: Sequence[str]) -> str:
    """The first cell that is no number: the operation, before remarks and tools."""
    return next((cell for cell in cells if any(map(str.isalpha, cell))), next(filter(None, cells), ""))
