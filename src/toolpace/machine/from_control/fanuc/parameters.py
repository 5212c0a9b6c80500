"""Values of parameters, from the text that a Fanuc control punches, each with its file and line.

Formats after the parameter manuals: `N01420A1P15000A2P15000` of 16i, 18i, 21i and 0i to 0i-C; `N01420Q1A1P15000.0`
and `N19700Q1L1P10.0` of 30i, 31i, 32i and 0i-D (B-63950EN/02, chapter 3.3, pages 8 to 12; real numbers of 15i:
B-63330EN/03, page 25). N is the parameter, A an axis, L a path, S a spindle, T a machine group; P, M or I goes before
the value, M and I with millimetres and inches. Q1 is parameters, other Q are other data. Bits are eight digits, the
last one bit 0.

Old controls keep whole numbers in their least increment, newer ones real numbers with a decimal point. A number without
one is read as the former only where nothing in the file is of the latter.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation

from toolpace.machine.from_control.control_file import SHOWN, ControlFile, ControlFileError
from toolpace.machine.from_control.record import Figure, Origin

MOST_LINES = 200_000
"""Of one file: a control with ten paths punches some twenty thousand."""
LINE = re.compile(r"\s*+N\s*+(\d{1,5})((?:\s*+[QALSTPMI]\s*+[-+]?[\d.]*+)++)\s*+;?\s*+$")
_WORD = re.compile(r"([A-Z])\s*([-+]?[\d.]*)")
_NUMBER = re.compile(r"[-+]?(?:\d{1,20}\.?\d{0,20}|\.\d{1,20})")
LENGTHS = frozenset({1320, 1321, 19666, 19667, *range(19700, 19706), *range(19709, 19715)})
ANGLES = frozenset({19683, 19685, 19688, 19690, 19698, 19699})
FEEDS = frozenset({1420, 1422, 1430, 1432, 1732, 1770, 1783})
ACCELERATIONS = frozenset({1660, 1671, 1735, 1737, 1788, 1789})
REAL = LENGTHS | ANGLES | FEEDS | ACCELERATIONS
"""Whole numbers on old controls, real ones on newer controls."""
BITS = frozenset({1001, 1004, 1006, 1013, 19665, 19696})
WHOLE = frozenset({981, 1020, 1022, 1620, 1622, 1672, 1769, 1771, 1772, 1785, 19680, 19681, 19682, 19684, 19686, 19687,
                   19689, 19697})  # fmt: skip
READ = REAL | BITS | WHOLE
"""Numbers of the parameters that are read; all others are passed over."""
OF_AXES = frozenset({1320, 1321, 1420, 1660})
"""Those that each axis has for itself."""
_MARK = re.compile(r"(?:%|[O:]\d+|;|[\x00-\x20])*")
"""What a tape has beside parameters: its ends, the number of a program, ends of blocks."""
LEAST = {"A": "0.01", "B": "0.001", "C": "0.0001", "D": "0.00001", "E": "0.000001"}
"""By increment system: the least increment of an old control [mm or deg]; a tenth of it in inches."""
INCREMENT_BITS = {0: "A", 1: "C", 2: "D", 3: "E"}
"""Bits of 1013 (newer controls) and 1004 (old ones, bits 0 and 1); IS-B without any."""


@dataclass(frozen=True)
class Value:
    """A number as it stands in a line."""

    text: str
    origin: Origin
    keyword: str = "P"
    """P, or M and I where the number is in millimetres or inches whatever the machine is in."""


@dataclass
class Parameters:
    """All values, by number of the parameter and by axis or path; 0 where the line names neither."""

    files: tuple[str, ...]
    values: dict[tuple[int, int], Value] = field(default_factory=dict)
    real: Value | None = None
    """The first value by which the file is of a newer control, with real numbers."""
    cut: list[str] = field(default_factory=list)
    """Files that do not end with %, as punched ones do."""
    strange: list[Origin] = field(default_factory=list)
    """Lines that are neither parameters nor marks of a tape."""
    paths: set[int] = field(default_factory=set)
    """Paths of the control that have values here."""

    def value(self, number: int, index: int = 0) -> Value | None:
        """The value of an axis, of path 1 where an index of a path stands there, or without index."""
        own = self.values.get((number, index))
        return self.values.get((number, 1)) if own is None and index == 0 else own

    def whole(self, number: int, index: int = 0) -> Figure | None:
        """A whole number, as that of an axis or a time in ms. Raises ControlFileError where it is none."""
        value = self.value(number, index)
        if value is None:
            return None
        count = _decimal(value)
        if count != int(count):
            raise value.origin.error(f"= {value.text}; give a whole number")
        return Figure(float(count), (value.origin,))

    def bit(self, number: int, bit: int, index: int = 0) -> tuple[bool, Origin] | None:
        """One bit, with its origin; None where the parameter is not there. Raises ControlFileError."""
        value = self.value(number, index)
        if value is None:
            return None
        if not re.fullmatch(r"[01]{8}", value.text):
            raise value.origin.error(f"= {value.text[:SHOWN]}; give eight digits 0 or 1, as the control punches bits")
        origin = Origin(f"{value.origin.name} #{bit}", value.origin.file, value.origin.line)
        return value.text[7 - bit] == "1", origin

    @property
    def inch(self) -> tuple[bool, Origin]:
        """Whether the machine's own units are inches, by 1001#0 (INM)."""
        return self.bit(1001, 0) or (False, Origin("N01001 is not in the files: a machine in millimetres (assumption)"))

    def figure(self, number: int, index: int, *, rotary: bool) -> Figure | None:
        """A length, angle, feed or acceleration in the machine's units: mm or inches, degrees, minutes of feeds.

        Raises ControlFileError for a number of which nobody can say the unit.
        """
        value = self.value(number, index)
        if value is None:
            if index > 0 and number in OF_AXES and (alone := self.values.get((number, 0))) is not None:
                raise alone.origin.error(f"= {alone.text[:SHOWN]} names no axis; write A1 before it, A2 and so on")
            return None
        figure = _decimal(value)
        inch = self.inch[0] and not rotary
        if "." in value.text:
            scale = Decimal(1)
        elif self.real is None:
            scale = self._increment(number, index, inch)
        elif figure == 0:
            scale = Decimal(1)
        else:
            raise value.origin.error(
                f"= {value.text} has no decimal point, and {self.real.origin} = {self.real.text} is of a control that "
                "writes one; write the number with its point"
            )
        if not rotary and value.keyword == "IM"[inch]:
            scale *= Decimal(1) / Decimal("25.4") if inch else Decimal("25.4")
        return Figure(float(figure * scale), (value.origin,))

    def _increment(self, number: int, index: int, inch: bool) -> Decimal:
        """What one stands for on an old control."""
        tenth = Decimal("0.1") if inch else Decimal(1)
        if number in LENGTHS | ANGLES:
            return Decimal(LEAST[self._system(index)]) * tenth
        return tenth

    def _system(self, index: int) -> str:
        """The increment system of an axis, or of all (IS-B where no bit is set)."""
        for number, place in ((1013, index), (1013, 1), (1004, 0)):
            if self.value(number, place) is not None:
                bits = INCREMENT_BITS if number == 1013 else {0: "A", 1: "C"}
                return next((name for bit, name in bits.items() if (self.bit(number, bit, place) or (False,))[0]), "B")
        return "B"

    def axes(self, number: int) -> list[int]:
        """The axes that a parameter has values of."""
        return sorted(index for key, index in self.values if key == number and index > 0)


def _decimal(value: Value) -> Decimal:
    if not _NUMBER.fullmatch(value.text):
        raise value.origin.no_number(value.text)
    try:
        return Decimal(value.text)
    except InvalidOperation:
        raise value.origin.no_number(value.text) from None


def read_parameters(files: Sequence[ControlFile]) -> Parameters:
    """The values of punched files. Raises ControlFileError for lines that are none, and for two unlike values."""
    parameters = Parameters(tuple(file.name for file in files))
    for file in files:
        if len(file.lines) > MOST_LINES:
            raise ControlFileError(f"has more than {MOST_LINES} lines: these are no parameters", file=file.name)
        number = 0
        for line_number, raw in enumerate(file.lines, 1):
            line = re.sub(r"\([^)]*\)?", " ", raw).strip().upper()
            if line.startswith("G10"):
                raise ControlFileError(
                    f"'{line[:SHOWN]}' is a program that sets parameters; give those that the control punches",
                    file=file.name, line=line_number,
                )  # fmt: skip
            number = _read_line(parameters, Origin("", file.name, line_number), line, number)
        if not any(line.strip() == "%" for line in file.lines[-3:]):
            parameters.cut.append(file.name)
    return parameters


def _read_line(parameters: Parameters, at: Origin, line: str, number: int) -> int:
    """Keep the values of one line; a line that begins with an axis goes on with the parameter of the line before."""
    if begins := re.match(r"N\s*(\d+)", line):
        number, rest = int(begins[1]), line[begins.end() :]
    elif number and re.match(r"[ALST]\s*\d", line):
        rest = line
    else:
        if not _MARK.fullmatch(line):
            parameters.strange.append(Origin(f"'{line[:SHOWN]}'", at.file, at.line))
        return 0
    if number not in READ:
        return number
    if not LINE.match(f"N{number:05d} {rest}"):
        raise ControlFileError(
            f"'{line[:SHOWN]}' is no line of a parameter; it has N, A or L, and P, M or I before a number",
            file=at.file, line=at.line,
        )  # fmt: skip
    for index, value in _values(parameters, at, number, rest):
        _keep(parameters, number, index, value)
    return number


def _values(parameters: Parameters, at: Origin, number: int, rest: str) -> Iterator[tuple[int, Value]]:
    """The values of the rest of a line, with their axis or path; values without any count axes from 1."""
    selector, index, count = "", 0, 0
    for letter, text in _WORD.findall(rest):
        if letter == "Q":
            if text not in ("", "1"):
                return
            parameters.real = parameters.real or Value(f"Q{text}", Origin(f"N{number:05d} Q{text}", at.file, at.line))
        elif letter in "ALST":
            selector, index = letter, int(text) if text.isdigit() and len(text) < 4 else 0
        elif letter in "PMI" and text:
            count += 1
            place = f"{selector}{index}" if selector else ""
            name = f"N{number:05d} {place}".strip()
            value = Value(text, Origin(name, at.file, at.line), letter)
            if number in REAL and "." in text:
                parameters.real = parameters.real or value
            if selector == "L":
                parameters.paths.add(index)
            if selector in ("", "A", "L"):
                yield (index if selector else count if _several(rest) else 0), value


def _several(rest: str) -> bool:
    """Whether a line without axes has several values: those of axis 1, 2, ..."""
    return len(re.findall(r"[PMI]\s*[-+\d.]", rest)) > 1


def _keep(parameters: Parameters, number: int, index: int, value: Value) -> None:
    """Keep a value; twice the same is no fault."""
    first = parameters.values.setdefault((number, index), value)
    if (first.text, first.keyword) != (value.text, value.keyword):
        raise value.origin.error(
            f"= {value.text[:SHOWN]} contradicts {first.origin} = {first.text[:SHOWN]}; remove one of both lines"
        )
