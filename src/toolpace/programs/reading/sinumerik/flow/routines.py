"""The routines of a file: main program and subprograms."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from toolpace.programs.reading.flow import Labels, Nesting
from toolpace.programs.reading.sinumerik.syntax.blocks import Line
from toolpace.programs.reading.sinumerik.syntax.statements import Head, head, line
from toolpace.programs.reading.source import Source

SUFFIXES = (".spf", ".SPF", ".mpf", ".MPF", "")
"""Of files that a subprogram is looked for in, beside the program."""
LARGEST = 16 << 20
"""Most bytes of a subprogram's file."""
MOST_FILES, LONGEST_NAME = 200, 64
"""Names that are looked for beside a program, and characters of one: bounds on what a program may ask for."""
_OPENING = re.compile(r"[ \t]*+%_N_([A-Z0-9_.-]+?)(?:_(MPF|SPF))?[ \t]*+(?:;.*)?", re.IGNORECASE)
_PROCEDURE = re.compile(r"[ \t]*+(?:N[0-9]++[ \t]*+)?PROC[ \t]++([A-Z_][A-Z0-9_]*+)", re.IGNORECASE)
_WORDS = "IF|ELSE|ENDIF|FOR|ENDFOR|WHILE|ENDWHILE|LOOP|ENDLOOP|REPEAT|UNTIL"
# Blanks are never given back: several runs of them that could share one take its length to the fourth power.
_STRUCTURED = re.compile(
    rf"\s*+(?:/[0-9]?+\s*+)?(?:[N:]\s*+[0-9]++\s*+)?(?:\w++\s*+:\s*+)?(?:{_WORDS})\b",
    re.IGNORECASE,
)
DEEPEST = 16
"""Choices and loops within each other in one program."""
CLOSES = {"ENDIF": "IF", "ELSE": "IF", "ENDFOR": "FOR", "ENDWHILE": "WHILE", "ENDLOOP": "LOOP", "UNTIL": "REPEAT"}
STRUCTURES = frozenset({*CLOSES, *CLOSES.values()})


class StructureFault(Exception):
    """A loop or a choice without its end, or an end without its beginning."""

    def __init__(self, message: str, index: int) -> None:
        super().__init__(message)
        self.index = index


@dataclass
class Routine:
    """Blocks that are executed one after the other."""

    name: str
    lines: tuple[str, ...]
    first: int
    """Line of the file, from 1, of lines[0]."""
    file: str = ""
    """Of a subprogram in a file of its own."""
    is_main: bool = False
    """Whether %_N_..._MPF opens it."""

    def read(self, index: int) -> tuple[Head, Line]:
        """What a line says."""
        found = head(self.lines[index])
        return found, line(found.rest)

    def check(self) -> None:
        """Raise StructureFault where choices and loops have no partners."""
        _ = self.nesting

    @cached_property
    def nesting(self) -> Nesting:
        """Which choices, loops and ends belong together. Raises StructureFault."""
        found = Nesting()
        spoilt: StructureFault | None = None  # the first IF or FOR that cannot be read, which is why others do not fit
        for index, text in enumerate(self.lines):
            if not _STRUCTURED.match(text):
                continue
            block = self.read(index)[1].block
            kind = "" if block.flow is None else block.flow.kind
            if block.fault and spoilt is None:
                spoilt = StructureFault(block.fault, index)
            if kind not in STRUCTURES:
                continue
            beginning = head(text)
            if beginning.skip or beginning.label:
                raise StructureFault(f"{kind} has neither / nor a label before it (alarm 12630)", index)
            if kind not in CLOSES:
                found.begin(kind, index)
                if len(found.opened[""]) > DEEPEST:
                    raise StructureFault(f"choices and loops are more than {DEEPEST} deep (alarm 12641)", index)
                continue
            innermost = found.innermost()
            if innermost is None or innermost.kind != CLOSES[kind]:
                inside = f", the last open one is {innermost.kind}" if innermost else ""
                raise spoilt or StructureFault(
                    f"{kind} stands without its {CLOSES[kind]}{inside}: correct the nesting", index
                )
            if kind == "ELSE":
                found.branch(index)
            else:
                found.close(index)
        unclosed = found.innermost()
        if unclosed is not None:
            raise spoilt or StructureFault(f"{unclosed.kind} is never closed: write its end", unclosed.parts[-1])
        return found

    @cached_property
    def labels(self) -> Labels:
        """Labels and block numbers."""
        found = Labels()
        for index, text in enumerate(self.lines):
            beginning = head(text)
            for name in (beginning.label, beginning.number):
                if name:
                    found.add(name, index)
        return found

    def target(self, kind: str, label: str, index: int) -> int | None:
        """Index of the label of a jump from here: GOTOF looks forward, GOTOB back, GOTO both."""
        below = None if kind == "GOTOB" else self.labels.below(label, index)
        return self.labels.above(label, index) if below is None and kind != "GOTOF" else below


@dataclass
class Library:
    """Routines by name."""

    source: Source
    routines: dict[str, Routine] = field(default_factory=dict)
    main: Routine = field(init=False)
    searched: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        found = routines_of(self.source.lines)
        self.main = next((routine for routine in found if routine.is_main), found[0])
        self.add([routine for routine in found if routine is not self.main])

    def add(self, found: list[Routine]) -> None:
        """Make routines known by their names; the first of a name counts."""
        for routine in found:
            self.routines.setdefault(routine.name, routine)

    def find(self, name: str) -> Routine | None:
        """A routine of the file, or of a file beside it; None where there is none.

        Raises ProgramError where such a file cannot be read.
        """
        name = name.replace("\\", "/").rpartition("/")[2].upper()
        name = name.removeprefix("_N_")
        for ending in ("_SPF", "_MPF", ".SPF", ".MPF"):
            name = name.removesuffix(ending)
        if name not in self.routines and name not in self.searched and len(self.searched) < MOST_FILES:
            self.searched.add(name)
            self._search_beside(name)
        return self.routines.get(name)

    def lines_beside(self) -> int:
        """Lines of the routines that stand in other files."""
        return sum(len(routine.lines) for routine in self.routines.values() if routine.file)

    def _search_beside(self, name: str) -> None:
        folder = Path(self.source.name).parent
        if len(name) > LONGEST_NAME or not name.replace("_", "").isalnum() or not _is_file(Path(self.source.name)):
            return
        for spelling in (name, name.lower(), f"_N_{name}_SPF"):
            for suffix in SUFFIXES:
                path = folder / (spelling + suffix)
                if _is_file(path):
                    loaded = Source.load(path)
                    found = routines_of(loaded.lines, path.name)
                    found[0].name = name
                    self.add(found)
                    return


def _is_file(path: Path) -> bool:
    """Whether there is a file that can be read, and is none too large."""
    try:
        return path.is_file() and path.stat().st_size <= LARGEST
    except (OSError, ValueError):
        return False


def routines_of(lines: tuple[str, ...], file: str = "") -> list[Routine]:
    """Routines of a file: each begins with %_N_NAME_SPF or PROC; what stands before the first is the main program."""
    starts: list[tuple[str, int, bool]] = []
    mains: set[int] = set()
    named = False
    for index, text in enumerate(lines):
        if "%" in text and (opening := _OPENING.fullmatch(text)):
            starts.append((opening[1].upper(), index + 1, True))
            if (opening[2] or "").upper() == "MPF":
                mains.add(index + 1)
            named = True
        elif procedure := _PROCEDURE.match(text):
            # PROC right behind %_N_..._SPF, or at the head of the file, opens no routine of its own
            if not (named and not _said(lines[starts[-1][1] : index])):
                starts.append((procedure[1].upper(), index, False))
            named = False
    if not starts or _said(lines[: starts[0][1] - starts[0][2]]):
        starts.insert(0, ("", 0, False))
    found = []
    for (name, start, _), following in zip(starts, [*starts[1:], ("", len(lines), False)]):
        found.append(Routine(name, lines[start : following[1] - following[2]], start + 1, file, start in mains))
    return found


def _said(lines: tuple[str, ...]) -> bool:
    """Whether anything but comments stands in lines."""
    return any(text and not text.startswith("%") for text in (line.split(";", 1)[0].strip() for line in lines))
