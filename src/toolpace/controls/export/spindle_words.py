"""The S words of a program, and the program with other ones: G-code, Sinumerik, Klartext, cutter-location data.

What an S governs is not worked out from the text: the program is read with a number of its own in each S, and the
speed of each point tells which one is in force there.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import ToolpaceError, VerificationError
from toolpace.controls.export.feed_words import NUMBER, bare, code_of
from toolpace.controls.export.rewriting import Passes, ProgramText
from toolpace.machine.machine import Machine
from toolpace.programs.reading import ReadOptions, Source, read_source
from toolpace.programs.reading.languages import recognised
from toolpace.programs.toolpath import ToolPath

FIRST = 71_003
"""Turns per minute of the first S with which the program is read to learn what each governs; the next has one more. No
variable has such a speed by chance."""
MOST = 5000
"""S words that are told apart."""
SAME_SPEED = 1e-6
"""Share by which a speed that is read back may be off by rounding."""
_WORD = re.compile(rf"(?<![A-Z0-9_.#$\]])S(?:[0-9]*[ \t]*=)?[ \t]*({NUMBER})(?![ \t]*[-+*/(\[=]|[ \t]*[0-9.])")
_CALL = re.compile(r"^[ \t/]*(?:[0-9]+[ \t]+)?TOOL[ \t]+CALL\b", re.IGNORECASE)
_KLARTEXT = re.compile(r"(?<![A-Z0-9])S[ \t]*([0-9]+(?:[.,][0-9]*)?)(?![ \t]*[0-9.,])", re.IGNORECASE)
_SPINDL = re.compile(rf"^[ \t]*SPINDL[ \t]*/[^$]*?(?<![A-Z0-9.])({NUMBER})", re.IGNORECASE)


@dataclass(frozen=True)
class SpindleWords:
    """The S words of a program, k of them, and the points that each governs."""

    source: Source
    machine: Machine
    dialect: str | None
    options: ReadOptions
    toolpath: ToolPath
    text: ProgramText
    words: tuple[tuple[int, int, int], ...]
    """(k,) line, and where in it the number begins and ends."""
    word: Ints
    """(points,) the word in force on the way to each point; -1 where none that can be changed is."""

    @classmethod
    def of(
        cls, source: Source, machine: Machine, dialect: str | None, options: ReadOptions, toolpath: ToolPath
    ) -> SpindleWords:
        """Those of a program that was read as `toolpath`."""
        found = recognised(source, dialect, options)
        language = found.controller.language if found.controller is not None else found.dialect
        text = ProgramText.of(source.data)
        words = tuple(_words(language, text.lines))
        none = cls(source, machine, dialect, options, toolpath, text, words, np.full(len(toolpath), -1))
        if not 0 < len(words) <= MOST:
            return none
        try:
            probed = none.read(none.written({k: f"{FIRST + k}" for k in range(len(words))}))
        except ToolpaceError:
            return none
        if len(probed) != len(toolpath) or not _same_path(probed, toolpath):
            return none
        speed = np.nan_to_num(np.abs(probed.spindle) * 60.0)
        word = np.rint(speed).astype(np.int64) - FIRST
        told = (np.abs(speed - np.rint(speed)) < 1e-6) & (word >= 0) & (word < len(words))
        return cls(source, machine, dialect, options, toolpath, text, words, np.where(told, word, -1))

    def together(self) -> list[list[int]]:
        """Operations whose speeds change by one factor, by index: those that one word governs, and that hang together
        so. Left out are operations with a cycle, whose feed may be bound to the speed, or with a point at feed that no
        word governs."""
        path = self.toolpath
        at_feed = np.arange(len(path)) > 0
        at_feed &= ~path.rapid
        fixed = set(path.operation[at_feed & (self.word < 0)].tolist()) | set(path.operation[_in_cycles(path)].tolist())
        pairs = np.unique(np.stack([path.operation, self.word])[:, at_feed & (self.word >= 0)].T, axis=0)
        groups: list[tuple[set[int], set[int]]] = []
        for operation, word in pairs.tolist():
            hang = [each for each in groups if operation in each[0] or word in each[1]]
            groups = [each for each in groups if each not in hang]
            groups.append(
                ({operation}.union(*(each[0] for each in hang)), {word}.union(*(each[1] for each in hang)))
            )
        return [sorted(operations) for operations, _ in groups if not operations & fixed]

    def with_ratios(self, ratio: Sequence[float]) -> tuple[Source, ToolPath]:
        """The program, and how it reads, with the speed of each operation times a ratio.

        Raises VerificationError where it does not read back to the same path with these speeds.
        """
        values = {}
        factor = np.array(ratio)[self.toolpath.operation]
        for k in range(len(self.words)):
            points = np.flatnonzero((self.word == k) & ~self.toolpath.rapid)
            if len(points) and factor[points[0]] != 1.0:
                turns = abs(float(self.toolpath.spindle[points[0]])) * float(factor[points[0]]) * 60.0
                values[k] = f"{turns:.0f}"
        source = Source.from_bytes(self.written(values), self.source.name)
        again = self.read(source.data)
        wanted: Floats = self.toolpath.spindle * np.where(np.isin(self.word, list(values)), factor, 1.0)
        at_feed = ~self.toolpath.rapid & np.isfinite(wanted)
        if not _same_path(again, self.toolpath) or (
            np.abs(again.spindle - wanted)[at_feed] > SAME_SPEED * np.abs(wanted[at_feed]) + 0.6 / 60.0
        ).any():
            raise VerificationError("read back, the program with other S words moves otherwise; nothing was written")
        return source, again

    def written(self, values: Mapping[int, str]) -> bytes:
        """The file with other numbers in some words."""
        lines = [[line] for line in self.text.lines]
        for k in sorted(values, reverse=True):
            line, begin, end = self.words[k]
            lines[line][0] = lines[line][0][:begin] + values[k] + lines[line][0][end:]
        return self.text.with_lines(lines)

    def read(self, data: bytes) -> ToolPath:
        """The program as it reads. Raises ToolpaceError."""
        return read_source(Source.from_bytes(data, self.source.name), self.machine, self.dialect, self.options)

    def lines_of(self, operations: Collection[int]) -> list[int]:
        """Lines of the words that govern some operations, from 1."""
        points = np.isin(self.toolpath.operation, list(operations)) & (self.word >= 0) & ~self.toolpath.rapid
        return sorted({self.words[k][0] + 1 for k in np.unique(self.word[points]).tolist()})


def _words(language: str, lines: Sequence[str]) -> list[tuple[int, int, int]]:
    """Line, begin and end of the number of each S word that is one."""
    found = []
    for number, line in enumerate(lines):
        if language in ("word-address", "sinumerik"):
            matches = list(_WORD.finditer((bare(line) if language == "sinumerik" else code_of(line)).upper()))
        elif language == "heidenhain":
            code = line.split(";", 1)[0]
            matches = list(_KLARTEXT.finditer(code)) if _CALL.match(code) else []
        else:
            match = _SPINDL.match(line)
            matches = [] if match is None else [match]
        found += [(number, *match.span(1)) for match in matches]
    return found


def _same_path(one: ToolPath, other: ToolPath) -> bool:
    return len(one) == len(other) and all(
        bool((getattr(one, name) == getattr(other, name)).all())
        for name in ("tip", "axis", "block", "rapid", "stop", "dwell", "operation")
    )


def _in_cycles(toolpath: ToolPath) -> Bools:
    """(points,) whether a point is of a block with rapids and feeds: a cycle."""
    passes = Passes.of(toolpath)
    return np.isin(toolpath.block, passes.block[passes.mixed])
