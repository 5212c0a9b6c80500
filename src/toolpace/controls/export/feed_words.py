"""Feed words of programs, found, replaced and added: in G-code, Sinumerik, Klartext and cutter-location data."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

MODES = re.compile(r"(?<![A-Z_0-9])G[ \t]*0*9([345])(?![0-9.])", re.IGNORECASE)
"""G93, G94, G95."""
NUMBER = r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)"
_VALUE = re.compile(r"[-+]?+[ \t]*+[0-9.](?:[ \t]*+[0-9.])*+")
"""Blanks may stand within a number."""
_COMPUTED = re.compile(r"[-+]?(?:#+(?:[0-9]+|<[^<>]*>)?|E[0-9]+|)(\[)?")
_BEFORE_COMMENT = re.compile(r'(?:[^;"]|"[^"]*")*+')
_TEXT = re.compile(r'"[^"]*"')


class FeedWords(Protocol):
    """The words of one language."""

    inverse: ClassVar[bool]
    """Whether it has inverse times (G93)."""
    decimals: ClassVar[int]
    """Most decimals of an F."""

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """Which lines can bear an F of their own for one motion."""

    def feed_in(self, line: str) -> str:
        """The F of a line as it is written; empty where it has none."""

    def mode_in(self, line: str) -> str:
        """The word of a line that tells what F means (G93, G94, G95); empty where it has none."""

    def with_feed(self, line: str, feed: str, inverse: bool, in_force: str = "") -> list[str]:
        """The line with another F, or with one added; lines that must stand before it come first.

        in_force: the F before the line as it is written; one that is added is of its kind (per minute, turn, tooth).
        """

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """A line that sets an F again that was found before, behind blocks that had F of their own."""


def code_of(line: str) -> str:
    """A line of G-code in capitals with its comments blanked out, so that each letter keeps its place."""
    out, depth = [], 0
    for at, char in enumerate(line):
        if char == "(":
            depth += 1
        elif char == ";" and not depth:
            out.append(" " * (len(line) - at))
            break
        out.append(" " if depth else char)
        if char == ")" and depth:
            out[-1] = " "
            depth -= 1
    return "".join(out).upper()


@dataclass(frozen=True)
class WordAddress:
    """G-code: F123, F[#1*2], F#<name>."""

    inverse: ClassVar[bool] = True
    decimals: ClassVar[int] = 4
    _GROUP: ClassVar[re.Pattern[str]] = re.compile(r"(?<![A-Z_0-9.#])G[ \t]*0*([0-9]+(?:\.[0-9]+)?)", re.IGNORECASE)
    _WORD: ClassVar[re.Pattern[str]] = re.compile(r"(?<![A-Z_])F(?![0-9]+[ \t]*=)[ \t]*=?[ \t]*", re.IGNORECASE)
    _FLOW: ClassVar[re.Pattern[str]] = re.compile(
        r"^[ \t/]*(?:N[ \t]*[0-9]+[ \t]*)?(?:O[ \t]*[0-9<]|IF|WHILE|DO|END|GOTO|%)|THEN"
    )
    _CYCLES: ClassVar[frozenset[str]] = frozenset(
        (*map(str, range(81, 90)), "32", "33", "33.1", "34", "63", "73", "74", "76", "331", "332")
    )
    """Words behind which a position is a cycle or a thread."""
    _ENDS: ClassVar[frozenset[str]] = frozenset(["0", "1", "2", "3", "80", "5", "5.1", "5.2", "6.2"])
    """Words that end these."""

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """All but those of cycles and threads, whose F is not that of one motion, and statements."""
        found, cycle = [], False
        for line in lines:
            code = self._code(line)
            for number in self._GROUP.findall(code):
                cycle = number in self._CYCLES or (cycle and number not in self._ENDS)
            found.append(not cycle and self._FLOW.search(code) is None)
        return found

    def feed_in(self, line: str) -> str:
        """F with its value."""
        at = self._place(self._code(line))
        return line[at[0] : at[1]].strip() if at else ""

    def mode_in(self, line: str) -> str:
        """G93, G94 or G95."""
        mode = MODES.search(self._code(line))
        return f"G9{mode[1]}" if mode else ""

    def with_feed(self, line: str, feed: str, inverse: bool, in_force: str = "") -> list[str]:
        """F replaced, or added behind the last word; G93 before it where feeds are inverse times."""
        code = self._code(line)
        at = self._place(code)
        like = code[at[0] : at[1]] if at else in_force
        word = self._word(like, feed, inverse)
        if at is None:
            end = len(code.rstrip())
            line = f"{line[:end]} {word}{line[end:]}"
        else:
            blank = line[at[0] : at[1]]
            line = line[: at[0]] + word + blank[len(blank.rstrip()) :] + line[at[1] :]
        mode = MODES.search(self._code(line))
        if inverse and mode is None:
            end = len(self._code(line).rstrip())
            line = f"{line[:end]} G93{line[end:]}"
        elif inverse and mode is not None:
            line = line[: mode.start()] + "G93" + line[mode.end() :]
        return [line]

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """F alone, behind its mode where blocks before it had G93."""
        return f"{mode or 'G94'} {feed}".rstrip() if inverse else feed

    def _code(self, line: str) -> str:
        """The line without comments, each letter in its place."""
        return code_of(line)

    def _word(self, like: str, feed: str, inverse: bool) -> str:
        """A feed in the word that another one has; F1200 of a program that writes F800. is another on some controls."""
        return f"F{feed}." if "." in like and "." not in feed else f"F{feed}"

    def _place(self, code: str) -> tuple[int, int] | None:
        """Where F and its value stand."""
        match = self._WORD.search(code)
        if match is None:
            return None
        end = _value_end(code, match.end())
        return None if end is None else (match.start(), end)


def _value_end(code: str, at: int) -> int | None:
    """Where a value ends: a number, a variable, or an expression in brackets; None where there is none."""
    match = _VALUE.match(code, at)
    if match:
        return match.end()
    match = _COMPUTED.match(code, at)
    if match is None or match.end() == at:
        return None
    if match[1] is None:
        return match.end()
    depth, end = 1, match.end()
    while end < len(code) and depth:
        depth += {"[": 1, "]": -1}.get(code[end], 0)
        end += 1
    return end


@dataclass(frozen=True)
class Cldata:
    """APT and CLSF: FEDRAT stands before the motion, in a statement of its own."""

    inverse: ClassVar[bool] = False
    decimals: ClassVar[int] = 4
    _MOTION: ClassVar[re.Pattern[str]] = re.compile(r"^\s*GOTO\s*/", re.IGNORECASE)
    _FEED: ClassVar[re.Pattern[str]] = re.compile(r"^\s*FEDRAT\s*/", re.IGNORECASE)
    _FIGURE: ClassVar[re.Pattern[str]] = re.compile(
        rf"(?<=[/,])[ \t]*{NUMBER}(?:E[-+]?[0-9]+)?[ \t]*(?=,|$)", re.IGNORECASE
    )

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """GOTO, but in drilling cycles, whose feed stands in CYCLE."""
        found, cycle = [], False
        for line in lines:
            words = line.upper().replace(" ", "")
            if words.startswith("CYCLE/"):
                cycle = not words.startswith("CYCLE/OFF") and not words.startswith("CYCLE/NOMORE")
            found.append(not cycle and self._MOTION.match(line) is not None)
        return found

    def feed_in(self, line: str) -> str:
        """The whole statement."""
        return line.strip() if self._FEED.match(line) and "$" not in line else ""

    def with_feed(self, line: str, feed: str, inverse: bool, in_force: str = "") -> list[str]:
        """FEDRAT before the line, which stays as it is; in the unit of the one in force, where that is plain."""
        statement, count = self._FIGURE.subn(feed, in_force)
        return [statement if count == 1 else f"FEDRAT/{feed},MMPM", line]

    def mode_in(self, line: str) -> str:
        """Empty: there is no such word."""
        return ""

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """The statement again."""
        return feed


@dataclass(frozen=True)
class Klartext:
    """Heidenhain: F1234 behind the coordinates and before M; FMAX is a rapid, F behind M128 belongs to M128.

    FU is a feed per turn, FZ per tooth.
    """

    inverse: ClassVar[bool] = False
    decimals: ClassVar[int] = 3
    _PATHS: ClassVar[re.Pattern[str]] = re.compile(
        r"^[ \t/]*(?:[0-9]+[ \t]+)?[ \t/]*(?:LN|LP|L|CTP|CT|CR|CP|C|RND|CHF|APPR[ \t]+[A-Z]+|DEP[ \t]+[A-Z]+)(?=[ \t])",
        re.IGNORECASE,
    )
    _FEED: ClassVar[re.Pattern[str]] = re.compile(
        r"(?<![A-Z0-9])F[ \t]*(?:AUTO|([UZ]?)[ \t]*(?:[-+]?(?:[0-9]++[.,]?[0-9]*+|[.,][0-9]++|Q[LRS]?[0-9]++)))",
        re.IGNORECASE,
    )
    _FUNCTION: ClassVar[re.Pattern[str]] = re.compile(r"(?<![A-Z0-9])M[ \t]*[0-9Q]", re.IGNORECASE)

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """Blocks of the contour."""
        return [self._PATHS.match(line) is not None and "~" not in line for line in lines]

    def feed_in(self, line: str) -> str:
        """F with its value."""
        at = self._FEED.search(line, 0, self._words_end(line))
        return at[0] if at and self._PATHS.match(line) else ""

    def with_feed(self, line: str, feed: str, inverse: bool, in_force: str = "") -> list[str]:
        """F replaced, or added before the first M."""
        end = self._words_end(line)
        at = self._FEED.search(line, 0, end)
        like = at or self._FEED.match(in_force)
        word = f"F{((like[1] if like else '') or '').upper()}{feed}"
        if at:
            return [line[: at.start()] + word + line[at.end() :]]
        head = line[:end].rstrip()
        return [f"{head} {word}{line[len(head) : end]}{line[end:]}"]

    def mode_in(self, line: str) -> str:
        """Empty: there is no such word."""
        return ""

    def alone(self, feed: str, mode: str, inverse: bool) -> str:
        """A line without coordinates."""
        return f"L {feed}"

    def _words_end(self, line: str) -> int:
        """Where the first M or the comment begins."""
        code = line.split(";", 1)[0]
        match = self._FUNCTION.search(code)
        return match.start() if match else len(code)


@dataclass(frozen=True)
class Sinumerik(WordAddress):
    """Sinumerik: F100, F=R1, FZ=0.1 per tooth, FB=100 of one block; ; alone begins a comment."""

    _NAMED: ClassVar[re.Pattern[str]] = re.compile(
        r"(?<![A-Z0-9_$])(?:CYCLE|MCALL|HOLES|POCKET|SLOT|IF|ELSE|ENDIF|WHILE|FOR|LOOP|REPEAT|UNTIL|CASE|GOTO|CALL|DEF|PROC)",
        re.IGNORECASE,
    )
    _FEED: ClassVar[re.Pattern[str]] = re.compile(
        rf"(?<![A-Z0-9_$])F(?:[ \t]*{NUMBER}(?:EX[-+]?[0-9]+)?"
        rf"|[ZB]?[ \t]*=[ \t]*(?:{NUMBER}|R[0-9]+)(?![ \t]*[-+*/(\[]))",
        re.IGNORECASE,
    )
    _OTHER: ClassVar[re.Pattern[str]] = re.compile(r"(?<![A-Z0-9_$])F[ZB]?[ \t]*=", re.IGNORECASE)

    def editable(self, lines: Sequence[str]) -> list[bool]:
        """All but those of threads, cycles and statements, and those whose F is an expression."""
        codes = [bare(line) for line in lines]
        return [
            able and self._NAMED.search(code) is None and not self._unknown(code)
            for able, code in zip(super().editable(lines), codes)
        ]

    def feed_in(self, line: str) -> str:
        """F or FZ; FB is that of one block, and leaves what is in force."""
        found = super().feed_in(line)
        return "" if found[:2].upper() == "FB" else found

    def _word(self, like: str, feed: str, inverse: bool) -> str:
        letters = like[:2].upper()
        return f"{letters}={feed}" if letters == "FB" or (letters == "FZ" and not inverse) else f"F{feed}"

    def _code(self, line: str) -> str:
        return bare(line)

    def _place(self, code: str) -> tuple[int, int] | None:
        match = self._FEED.search(code)
        return None if match is None else match.span()

    def _unknown(self, code: str) -> bool:
        return self._OTHER.search(code) is not None and self._FEED.search(code) is None


def bare(line: str) -> str:
    """A line with its comment and its texts blanked out; a ; within a text begins no comment."""
    match = _BEFORE_COMMENT.match(line)
    end = match.end() if match else len(line)
    return _TEXT.sub(lambda text: '"' + "." * (len(text[0]) - 2) + '"', line[:end]) + " " * (len(line) - end)


LANGUAGES: dict[str, FeedWords] = {
    "word-address": WordAddress(),
    "sinumerik": Sinumerik(),
    "heidenhain": Klartext(),
    "cldata": Cldata(),
}
"""Language of a controller, or `cldata`, to its words."""
