"""Times of operations as a shop writes them down: a line each, with the operation and its time.

    Face the top, 1:23
    "Pocket, rough"; 2 min 5 s
    Drill        83.4 s
    total        6:10

A time is minutes and seconds (1:23), hours too (1:02:03), or figures with their units (h, min, s). How exact it is
follows from its last digit: 1:23 to a second, 83.4 s to a tenth, 2 min to a minute.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

from toolpace.common.errors import UsageError, printable
from toolpace.common.files import reason

TOTAL = ("", "total", "all", "program", "sum")
"""Names of the whole program."""
LONGEST = 1e7
"""[s]: a longer time is a slip."""
HOUR, MINUTE = 3600.0, 60.0
_FIGURE = r"\d+(?:[.,]\d+)?"
_CLOCK = re.compile(r"(?:(?P<h>\d+):)?(?P<min>\d+):(?P<s>\d\d(?:[.,]\d+)?)")
_UNITS = re.compile(
    rf"(?:(?P<h>{_FIGURE})\s*h(?:ours?)?)?\s*(?:(?P<min>{_FIGURE})\s*m(?:in(?:utes?)?)?\.?)?"
    rf"\s*(?:(?P<s>{_FIGURE})\s*s(?:ec(?:onds?)?)?\.?)?",
    re.IGNORECASE,
)
_TIME_AT_END = re.compile(
    rf"(?P<time>(?:\d+:)?\d+:\d\d(?:[.,]\d+)?|{_FIGURE}\s*(?:h(?:ours?)?|m(?:in(?:utes?)?)?\.?|s(?:ec(?:onds?)?)?\.?)"
    rf"(?:\s*{_FIGURE}\s*(?:m(?:in(?:utes?)?)?\.?|s(?:ec(?:onds?)?)?\.?)){{0,2}})\s*[;,]*\s*$",
    re.IGNORECASE,
)


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
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise UsageError(f"--fit {path}: cannot be read ({reason(error)}); check the path") from None
    except UnicodeDecodeError:
        raise UsageError(f"--fit {path}: no text (UTF-8); save it as text or CSV") from None
    found: list[WrittenTime] = []
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].strip()
        if not words or (not found and not any(map(str.isdigit, words))):
            continue  # of a heading, too
        at_end = _TIME_AT_END.search(words)
        time = None if at_end is None else written_time(at_end["time"])
        if at_end is None or time is None:
            raise UsageError(
                f"--fit {path}:{number}: '{printable(words[:60])}' ends with no time; write an operation and its time, "
                "such as: Pocket, 1:23 (or 83 s, 2 min 5 s). A log of the axes begins with a line that names its "
                "columns: t and the joints"
            )
        name = words[: at_end.start()].strip().rstrip(",;:\t ").strip().strip("\"'").strip()
        found.append(WrittenTime("" if name.lower() in TOTAL else name, time.seconds, time.resolution))
    if not found:
        raise UsageError(f"--fit {path}: there is no time in it; write an operation and its time: Pocket, 1:23")
    return found
