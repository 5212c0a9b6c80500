"""The findings of a reader: ignored words, assumptions, refusals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from toolpace.common.errors import ProgramError, printable
from toolpace.common.value_objects import counted
from toolpace.programs.reading.source import Source
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures

MOST_LISTED = 60
"""Refused words that a message lists: a file of more kinds is of another dialect."""
LENIENT = " (--lenient reads on)"
LONGEST_WORD = 80
"""Characters of a word that are shown; what is longer is a slip."""


@dataclass(frozen=True)
class Refusal:
    """A word that may move something and is not read."""

    word: str
    line: int
    """Line, from 1, on which it stands first."""
    count: int
    """How often it stands in the program."""
    cure: str
    """What to write in its place, or to leave out."""
    certain: bool = False
    """Whether it is read, and stops the control nevertheless."""

    def __str__(self) -> str:
        return f"{self.place}: {self.cure}"

    @property
    def place(self) -> str:
        """The word and where it stands."""
        times = f", {self.count} times" if self.count > 1 else ""
        return f"{self.word} (first line {self.line}{times})"


@dataclass
class Used:
    """What of a set-up sheet a program uses, in its order."""

    offsets: dict[str, None] = field(default_factory=dict)
    """Names of work offsets."""
    references: dict[int, None] = field(default_factory=dict)
    """Numbers of reference points."""
    tools: dict[str, None] = field(default_factory=dict)
    """Numbers or names of tools."""
    machine_zero: bool = False
    """Whether it moves in machine coordinates."""


class Findings:
    """Collected while a program is read; the reader goes on after a refused word, so that one run names all."""

    def __init__(self) -> None:
        self.skipped: Counter[str] = Counter()
        """Words without meaning for motion, and how often."""
        self.used = Used()
        self.tool_shapes: dict[str, ToolFigures] = {}
        """Shapes of tools by number or name, as the program tells them."""
        self.workpiece = WorkpieceFigures()
        """As the program tells it."""
        self.arcs = 0
        """Motions along arcs."""
        self._assumed: dict[str, None] = {}
        self._refusals: dict[str, Refusal] = {}

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What was taken for granted, a sentence each, in the order of the program."""
        return tuple(self._assumed)

    def assumptions_without(self, refusals: Iterable[Refusal]) -> tuple[str, ...]:
        """Those that do not say of one of these refusals that it is skipped."""
        skipped = {_skips(refusal) for refusal in refusals}
        return tuple(sentence for sentence in self._assumed if sentence not in skipped)

    @property
    def refusals(self) -> tuple[Refusal, ...]:
        """Refused words, each once, in the order of their first lines."""
        return tuple(sorted(self._refusals.values(), key=lambda refusal: refusal.line))

    def refusals_under(self, skip_unknown: bool, lenient: bool) -> tuple[Refusal, ...]:
        """Those that end the reading: none with `skip_unknown`; with `lenient` not what is read, and stops the control.
        """
        return tuple(each for each in self.refusals if not (skip_unknown or (lenient and each.certain)))

    def ignored(self, word: str) -> None:
        """Count a word that has no meaning for motion."""
        self.skipped[_shown(word)] += 1

    def assumed(self, sentence: str) -> None:
        """Note what the program leaves open and how it was taken; a sentence said before is not said again."""
        self._assumed.setdefault(printable(sentence))

    def refused(self, word: str, line: int, cure: str, *, certain: bool = False) -> None:
        """Note a word that is not read; later ones are counted, with the line and the cure of the first."""
        word = _shown(word)
        refusal = self._refusals.get(word)
        if refusal is None:
            self._refusals[word] = Refusal(word, line, 1, cure, certain)
        else:
            self._refusals[word] = replace(refusal, line=min(line, refusal.line), count=refusal.count + 1)

    def stops(self, what: str, line: int, cure: str) -> None:
        """Note what the control stops at, though its meaning is certain and it is read."""
        self.refused(what, line, cure, certain=True)

    def raise_if_refused(self, source: Source, skip_unknown: bool = False, lenient: bool = False) -> None:
        """One ProgramError that names every refused word; with `skip_unknown` each is an assumption instead.

        lenient: so is what is read, and stops the control.
        """
        refusals = self.refusals_under(skip_unknown, lenient)
        ending = set(refusals)
        for refusal in self.refusals:
            if refusal not in ending:
                self.assumed(_skips(refusal))
        if len(refusals) == 1:
            (only,) = refusals
            times = f" (it stands {only.count} times)" if only.count > 1 else ""
            said = "stops the control" if only.certain else "is not read"
            hint = LENIENT if only.certain else ""
            source.fail(f"{only.word} {said}: {only.cure}{times}{hint}", only.line)
        elif refusals:
            listed = _listed(refusals[:MOST_LISTED])
            if len(refusals) > MOST_LISTED:
                listed += f"; and {len(refusals) - MOST_LISTED} more"
            certain = sum(refusal.certain for refusal in refusals)
            said = "kinds of words are not read" if not certain else "things stop the control, or are not read"
            hint = LENIENT if certain == len(refusals) else ""
            raise ProgramError(f"{len(refusals)} {said}: {listed}{hint}", source=source.name)


def _shown(word: str) -> str:
    """A word as messages have it, in one line."""
    return printable(word if len(word) <= LONGEST_WORD else f"{word[:LONGEST_WORD]}...")


def _listed(refusals: tuple[Refusal, ...]) -> str:
    """Refused words in order, those with one cure together."""
    by_cure: dict[str, list[str]] = {}
    for refusal in refusals:
        by_cure.setdefault(refusal.cure, []).append(refusal.place)
    return "; ".join(f"{', '.join(places)}: {cure}" for cure, places in by_cure.items())


def _skips(refusal: Refusal) -> str:
    said = "read, though the control stops there:" if refusal.certain else "skipped"
    return f"{said} {refusal.word} (first line {refusal.line}, {counted(refusal.count, 'time')})"
