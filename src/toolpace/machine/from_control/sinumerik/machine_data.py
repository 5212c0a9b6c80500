"""Machine data and swivel data of a Sinumerik as text: `N32300 $MA_MAX_AX_ACCEL[0,AX1]=4 ;m/s2`.

Archives in ASCII, INITIAL.INI and printed lists have such lines, with or without numbers, checksums ('3a1f behind the
value) and comments (Commissioning Manual CNC, 6FC5397-2AP10, chapter 10). $MN data are general, $MC data of a channel
(of that of CHANDATA(n) before them, or of an index CHn), $MA data of a machine axis (AX1, or its name), $TC_CARR data
of a swivel data set, $NK data of an element of the kinematic chain and $NT data of its transformation (kin.ini). An
index that is left out is 0.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from toolpace.machine.from_control.control_file import SHOWN, ControlFile, ControlFileError
from toolpace.machine.from_control.record import Figure, Origin

COMMENT = re.compile(r'("[^"]*")|;.*')
DATUM = re.compile(
    r"""(?:\bN(?P<number>[0-9]{1,6})\s*)?\$(?P<name>[A-Z][A-Z0-9_]*)\s*(?:\[(?P<index>[^\]=]*)\])?\s*=\s*"""
    r"""(?P<value>"[^"]*"|'[HB][0-9A-F]*'|\([^)]*\)|[^\s"';$]+)?""",
    re.IGNORECASE,
)
SWITCHED_OFF = ("#", "//")
"""Beginnings of lines that a person switched off."""
OWN_UNIT = re.compile(
    r"mm|in(?:ch(?:es)?)?|deg(?:rees?)?|grad|m?s|%|(?:mm|in(?:ch)?|deg|rev|u|1)/min|rpm"
    r"|(?:m|in(?:ch)?|rev|umdr)/s(?:\^|\*\*)?[23²³]",
    re.IGNORECASE,
)
"""What a listing writes behind a value that is in the unit of the control."""
BEHIND = re.compile(r"\s*(?:'[0-9A-F]{1,4}\b)?\s*(?!N\d+\s*\$|\(|//|#)([^\s$]*)", re.IGNORECASE)
"""A word behind a value and its checksum that is neither the next datum nor a remark."""
ANY_DATUM = re.compile(r"\$(M[NCA]_[A-Z]|N[KT]_[A-Z]|TC_CARR[0-9])[A-Z0-9_]*\s*(\[[^\]=]*\])?\s*=", re.IGNORECASE)
KEPT = re.compile(
    r"""\$(?:MN_(?:AXCONF|SCALING|IPO_|SYSCLOCK)|MC_(?:AXCONF|TRAFO|GCODE_RESET|MAX_PATH|CURV_)|MA_(?:IS_ROT|ROT_IS|MAX_A|"""
    r"""JOG_VELO|ACCEL_RED|SOFT_|G00_|PATH_TRANS|POS_LIMIT|COMPRESS|SPIND_ASSIGN)|TC_CARR|SC_TOCARR|NK_|NT_)""",
    re.IGNORECASE,
)
"""Beginnings of names that are kept: an archive has some hundred times as many."""
CHANNEL = re.compile(r"\s*(?:CHANDATA\s*\(\s*([0-9]{1,2})\s*\)|%_N_CH0*([0-9]{1,2})_)", re.IGNORECASE)
EXPONENT = re.compile(r"([0-9.])EX(?=[-+0-9])", re.IGNORECASE)
LARGEST = 1e12
"""Beyond which no datum is: the control's own default of a travel is 1e8."""
MOST = 50_000
"""Data that are kept: a control with 31 axes and as many swivel data sets has some four thousand."""
Key = tuple[str, int, str, int]
"""Name, number, axis (or what else stands in the index) and channel; empty and 0 where none is named."""


@dataclass(frozen=True)
class Datum:
    """A value as it stands in a file."""

    text: str
    origin: Origin
    behind: str = ""
    """A word behind the value that is no unit of the control."""

    def number(self) -> float:
        """As a number; TRUE is 1, 'H1F' and 'B101' are whole numbers. Raises ControlFileError."""
        if self.behind:
            raise self.origin.error(
                f"= {self.text[:20]} has '{self.behind[:20]}' behind it; give the number alone, in the control's unit"
            )
        word = self.text.strip("() ").upper()
        if word in ("TRUE", "FALSE"):
            return float(word == "TRUE")
        try:
            if word.startswith(("'H", "'B")):
                return float(int(word[2:-1], 16 if word[1] == "H" else 2))
            value = float(EXPONENT.sub(r"\1E", word).replace("_", "x"))
        except (ValueError, OverflowError):
            raise self.origin.no_number(self.text) from None
        if not abs(value) < LARGEST:
            raise self.origin.error(f"= '{self.text[:20]}' is too large; correct it on the control")
        return value

    def word(self) -> str:
        """As a name: without quotes and brackets, in capitals."""
        return self.text.strip('"() ').upper()

    def same(self, other: Datum) -> bool:
        """Whether both say the same."""
        if self.word() == other.word():
            return True
        try:
            return self.number() == other.number()
        except ControlFileError:
            return False

    def figure(self, unit: str = "") -> Figure:
        """As a number with its origin."""
        return Figure(self.number(), (self.origin,), unit)


@dataclass
class MachineData:
    """All data of some files, by key; `channel` is the one of which $MC data are asked for."""

    data: dict[Key, list[Datum]] = field(default_factory=dict)
    channel: int = 0
    strange: list[Origin] = field(default_factory=list)
    """Lines that name a datum and assign nothing to it."""

    @staticmethod
    def of(files: Iterable[ControlFile]) -> MachineData:
        """The data of files. Raises ControlFileError where one has none."""
        found, count = MachineData(), 0
        for file in files:
            if not has_data(file):
                wanted = "$MN_, $MC_, $MA_, $TC_CARR, $NK_, $NT_"
                raise ControlFileError(f"has no machine data ({wanted}); leave it out", file=file.name)
            channel = 0
            for number, line in enumerate(file.lines, 1):
                if match := CHANNEL.match(line):
                    channel = int(match[1] or match[2])
                if "$" in line and KEPT.search(line) and not line.lstrip().startswith(SWITCHED_OFF):
                    count += 1
                    found._add(file, number, COMMENT.sub(r"\1", line), channel)
                    if count > MOST:
                        raise ControlFileError(
                            f"has more than {MOST} lines of axes and transformations; give one machine at a time",
                            file=file.name,
                        )
        return found

    def _add(self, file: ControlFile, line: int, text: str, channel: int) -> None:
        """Keep what a line assigns."""
        if KEPT.search(text) and not DATUM.search(text):
            self.strange.append(Origin(f"'{text.strip()[:SHOWN]}'", file.name, line))
        for match in DATUM.finditer(text):
            name = match["name"].upper()
            if not KEPT.match("$" + name):
                continue
            shown = f"${name}" + (f"[{match['index'].strip()}]" if match["index"] is not None else "")
            shown = (f"N{match['number']} " if match["number"] else "") + shown[:SHOWN]
            numbers, others, of = [], [], channel
            for part in filter(None, (match["index"] or "").upper().replace(" ", "").split(",")):
                if re.fullmatch(r"CH[0-9]{1,2}", part):
                    of = int(part[2:])
                elif re.fullmatch(r"[0-9]{1,4}", part):
                    numbers.append(part)
                else:
                    others.append(part)
            key = (name, int(numbers[0]) if numbers else 0, ",".join(others + numbers[1:]),
                   of if name.startswith("MC_") else 0)  # fmt: skip
            word = found[1] if (found := BEHIND.match(text, match.end())) else ""
            behind = "" if OWN_UNIT.fullmatch(word) else word
            self.data.setdefault(key, []).append(Datum(match["value"] or "", Origin(shown, file.name, line), behind))

    @property
    def channels(self) -> list[int]:
        """Channels that data are of; 0 alone where the files name none."""
        return sorted({key[3] for key in self.data if key[0].startswith("MC_")} - {0}) or [0]

    def numbers(self, prefix: str) -> list[int]:
        """Numbers in the index of names that begin so."""
        return sorted({key[1] for key in self.data if key[0].startswith(prefix)})

    @property
    def has_kinematic_chain(self) -> bool:
        """Whether there are elements of a kinematic chain."""
        return any(key[0].startswith("NK_") for key in self.data)

    def axis_words(self) -> list[str]:
        """Axes of $MA data, in the order of the files."""
        return list(dict.fromkeys(key[2] for key in self.data if key[0].startswith("MA_") and key[2]))

    def datum(self, name: str, number: int = 0, axes: Sequence[str] = ("",)) -> Datum | None:
        """What is assigned to a name, under any name of its axis. Raises ControlFileError where values contradict."""
        keys = ((name, number, axis, channel) for axis in dict.fromkeys(axes) for channel in {self.channel, 0})
        found = [datum for key in keys for datum in self.data.get(key, [])]
        for other in found[1:]:
            if not other.same(found[0]):
                one_file = other.origin.file == found[0].origin.file
                cure = "remove one of both lines" if one_file else "give the newer file"
                raise other.origin.error(
                    f"= {other.text[:20] or 'nothing'} contradicts {found[0].origin} = "
                    f"{found[0].text[:20] or 'nothing'}; {cure}"
                )
        return found[0] if found else None

    def figure(self, name: str, number: int = 0, axes: Sequence[str] = ("",), unit: str = "") -> Figure | None:
        """The same as a number."""
        datum = self.datum(name, number, axes)
        return None if datum is None else datum.figure(unit)

    def vector(self, places: Sequence[tuple[str, int] | tuple[str, int, tuple[str, ...]]]) -> Figure | None:
        """Three numbers under these names and indices; those that are missing are 0, and None is for all three."""
        data = [self.datum(*place) for place in places]
        present = [datum for datum in data if datum is not None]
        if not present:
            return None
        values = tuple(0.0 if datum is None else datum.number() for datum in data)
        return Figure(values, _in_short([datum.origin for datum in present]))


def has_data(file: ControlFile) -> bool:
    """Whether a text assigns machine data or swivel data."""
    return any("$" in line and ANY_DATUM.search(line) for line in file.lines)


def _in_short(origins: Sequence[Origin]) -> tuple[Origin, ...]:
    """Origins of the components of a vector: of lines one below the other the first and the last are enough."""
    first, last = origins[0], origins[-1]
    below = [(first.file, first.line + k) for k in range(len(origins))]
    if len(origins) == 1 or [(origin.file, origin.line) for origin in origins] != below:
        return tuple(origins)
    start, end = first.name.split(" ")[-1], last.name.split(" ")[-1]
    if start.partition("[")[0] == end.partition("[")[0]:
        end = end[end.find("["):]
    return (Origin(f"{first.name} to {end}", first.file, first.line),)
