"""The controller of a program, from signs in its words, its header and its name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import PurePath
from typing import NamedTuple

from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.source import Source

PLAIN = re.compile(
    r"[ \t]*+(N\d++)?((?:[ \t]*+(?:G0?[0-3](?![\d.])|[XYZABCIJKF][-+]?[\d.]++))*+)[ \t]*+;?+", re.IGNORECASE
)
"""A block of plain words: its number, and the words."""
FALLBACK = "iso"
LINES, LENGTH = 20_000, 300
"""How many lines are looked at, and how much of each: signs stand early, or often."""
SUFFIX_WEIGHT = 4.0
"""Of the ending of the name: whoever saved the program knew its control, as a word that one control alone has tells."""
USUAL = ("fanuc", "haas", "linuxcnc")
"""Controls that a program without signs may be for."""
MARGIN = 4.0
"""A control whose signs weigh less by this, or by more, is none that the program may be for."""
_BRACKETS = re.compile(r"[()]")
_BRACKETS_BEHIND_A_BLANK = re.compile(r"(?:^|(?<=[\s\d.]))\([^()]*+\)")


class Recognition(NamedTuple):
    """The control that a program is read for."""

    controller: Controller
    reason: str
    """The heaviest of its signs, in words."""
    others: tuple[Controller, ...]
    """Controls of the same language that it may be for as well: their signs weigh about as much."""


@cache
def built_in() -> tuple[Controller, ...]:
    """All of them; those that are like another behind the others, since they have its signs too."""
    return tuple(sorted(map(Controller.load, Controller.names()), key=lambda controller: controller.like != ""))


def recognise(source: Source, controllers: tuple[Controller, ...] | None = None) -> Recognition:
    """The controller whose signs weigh most; each sign counts once. Time is linear in the program.

    Where no sign is found it is the fallback, and `others` are the usual ones.
    """
    controllers = built_in() if controllers is None else controllers
    text = Text(line[:LENGTH] for line in source.lines[:LINES])
    suffix = PurePath(source.name).suffix.lower()
    weights = {controller.name: _weighed(controller, text, suffix) for controller in controllers}
    chosen = max(controllers, key=lambda controller: weights[controller.name][0])
    weight, reason = weights[chosen.name]
    if weight <= 0.0:
        chosen, reason = Controller.load(FALLBACK), "nothing in the program tells its controller"
    return Recognition(chosen, reason, tuple(_others(chosen, controllers, {n: w for n, (w, _) in weights.items()})))


def _weighed(controller: Controller, text: Text, suffix: str) -> tuple[float, str]:
    """What the signs of a controller weigh together, and the reason of the heaviest."""
    said = text.of(controller.language)
    found = [
        (sign.weight, sign.reason)
        for sign in controller.signs
        if re.search(sign.pattern, text.whole if sign.comments else said, re.MULTILINE)
    ]
    if suffix and suffix in controller.suffixes:
        found.append((SUFFIX_WEIGHT, f"names that end with {suffix} are of {controller.name}"))
    return sum(weight for weight, _ in found), max(found, default=(0.0, ""))[1]


def _others(chosen: Controller, controllers: Iterable[Controller], weights: dict[str, float]) -> Iterable[Controller]:
    """Those that the program may be for as well.

    Only the usual ones need no sign of their own, and the fallback is no control.
    """
    least = max(0.0, weights.get(chosen.name, 0.0)) - MARGIN
    for other in controllers:
        if other.name in (chosen.name, FALLBACK) or other.language != chosen.language:
            continue
        own = weights[other.name] - weights.get(other.like, 0.0)
        if weights[other.name] > least and (own > 0.0 or other.name in USUAL):
            yield other


class Text:
    """Lines of a program, in capitals; without plain motions, which most lines are and which tell nothing."""

    def __init__(self, lines: Iterable[str]) -> None:
        self._lines = [line.upper() for line in lines if not PLAIN.fullmatch(line)]
        self.whole = "\n".join(self._lines)
        """With the comments: what a post says of itself stands there."""
        self._without: dict[str, str] = {}

    def of(self, language: str) -> str:
        """Without what is a comment in a language; a semicolon begins one in each of them, or ends the block."""
        if language not in self._without:
            strip = {"word-address": _without_brackets, "sinumerik": _without_free_brackets}.get(language)
            code = (line.partition(";")[0] for line in self._lines)
            self._without[language] = "\n".join(map(strip, code) if strip else code)
        return self._without[language]


def _without_brackets(line: str) -> str:
    """Without what stands in round brackets, nested ones too; one that stays open ends with the line."""
    if "(" not in line:
        return line
    kept, depth, begin = [], 0, 0
    for bracket in _BRACKETS.finditer(line):
        if bracket[0] == "(":
            if depth == 0:
                kept.append(line[begin : bracket.start()])
            depth += 1
        elif depth:
            depth -= 1
            if depth == 0:
                begin = bracket.end()
    if depth == 0:
        kept.append(line[begin:])
    return "".join(kept)


def _without_free_brackets(line: str) -> str:
    """Without what stands in brackets behind a blank or a number.

    To Sinumerik brackets are arguments of the name before them; others are comments of another control.
    """
    return _BRACKETS_BEHIND_A_BLANK.sub("()", line)
