"""Feed words in G-code, with G93 for inverse-time feeds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

MODES = re.compile(r"(?<![A-Z_0-9])G[ \t]*0*9([345])(?![0-9.])", re.IGNORECASE)
"""G93, G94, G95."""
NUMBER = r"[-+]?(?:[0-9]++\.?[0-9]*+|\.[0-9]++)"
_VALUE = re.compile(r"[-+]?+[ \t]*+[0-9.](?:[ \t]*+[0-9.])*+")
"""Blanks may stand within a number."""
_COMPUTED = re.compile(r"[-+]?(?:#+(?:[0-9]+|<[^<>]*>)?|E[0-9]+|)(\[)?")


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

    def with_feed(self, line: str, feed: str, inverse: bool) -> list[str]:
        """F replaced, or added behind the last word; G93 before it where feeds are inverse times."""
        code, word = self._code(line), f"F{feed}"
        at = self._place(code)
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
