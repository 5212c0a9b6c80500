"""The controller of a program, from signs in it; and the blocks that others it may be for would read differently."""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from toolpace.common.arrays import Bools
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.source import Source
from toolpace.programs.toolpath import ToolPath

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
ALIKE = 1e-7
"""By how much places [m], directions and shares of feeds and times may differ and still be the same."""
SHOWN = 40
"""Most characters of a block in a sentence."""
CURE = "the program does not tell its control; name it with --controller"
_DWELL = re.compile(r"G0*4(?![\d.])", re.IGNORECASE)

Reading = Callable[[Controller, Source], ToolPath | None]
"""Reads a program as one for a controller; None where that refuses words. Raises ToolpaceError."""
Difference = tuple[int, str, str]
"""A line, and what the one and the other make of it."""
_LETTERS = re.compile(r"G0?[0-3]|F[-+]?[\d.]++|[A-Z]", re.IGNORECASE)
_JUMPS = re.compile(r"GOTO|M9[789]", re.IGNORECASE)
"""Words that go to numbers of blocks."""
KEPT = 3
"""Blocks of the same words that are kept of those between two that are not plain."""


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


def doubts(
    ours: ToolPath, taken: Controller, source: Source, others: Sequence[Controller], reading: Reading
) -> tuple[str, ...]:
    """Sentences on the first blocks whose way, feed or dwell others read differently.

    ours: the program as it is read for `taken`. Others that refuse the program are left out: on them nothing moves
    elsewhere. Long programs are tried without most of their plain motions first.
    """
    found: dict[tuple[int, str], dict[str, list[str]]] = {}
    short = thinned(source)
    mine = _read(taken, short, reading) if others else None
    for other in others:
        its = _read(other, short, reading) if mine is not None else None
        if mine is not None and its is not None and not any(_differences(mine, its, short)):
            continue
        theirs = _read(other, source, reading)
        for line, own, said in _differences(ours, theirs, source) if theirs is not None else ():
            found.setdefault((line, own), {}).setdefault(said, []).append(other.name)
    return tuple(
        f"line {line} '{source.lines[line - 1].strip()[:SHOWN]}' {own}, as for {taken.name}; "
        + "; ".join(f"for {' and '.join(names)} it {said}" for said, names in said_by.items())
        + f": {CURE}"
        for (line, own), said_by in sorted(found.items())
    )


def _read(controller: Controller, source: Source, reading: Reading) -> ToolPath | None:
    try:
        return reading(controller, source)
    except ToolpaceError:
        return None


def _differences(ours: ToolPath, theirs: ToolPath, source: Source) -> Iterator[Difference]:
    """The first line whose motion differs, and the first that waits another time."""
    yield from _motion(ours, theirs)
    own, other = _dwells(ours), _dwells(theirs)
    for line in sorted(own.keys() | other.keys()):
        mine, its = own.get(line, 0.0), other.get(line, 0.0)
        if not np.isclose(mine, its, rtol=ALIKE, atol=ALIKE):
            yield _line_of_dwell(ours, source, line), _waits(mine), _waits(its)
            return


def _motion(ours: ToolPath, theirs: ToolPath) -> Iterator[Difference]:
    n = min(len(ours.tip), len(theirs.tip))
    differ: Bools = (ours.block[:n] != theirs.block[:n]) | (ours.rapid[:n] != theirs.rapid[:n])
    for mine, its in ((ours.tip, theirs.tip), (ours.axis, theirs.axis)):
        differ |= (np.abs(mine[:n] - its[:n]) > ALIKE).any(axis=1)
    for mine, its in ((ours.feed, theirs.feed), (ours.least_time, theirs.least_time)):
        differ |= ~np.isclose(mine[:n], its[:n], rtol=ALIKE, atol=0.0)
    at = int(np.argmax(differ)) if differ.any() else n
    blocks = [int(path.block[at]) for path in (ours, theirs) if at < len(path.tip)]
    if blocks:
        line = min(blocks)
        yield line, _goes(ours, at, line), _goes(theirs, at, line)


def _goes(path: ToolPath, at: int, line: int) -> str:
    """What a path does at a point, as of a line."""
    if at >= len(path.tip) or path.block[at] != line:
        return "moves nothing more" if at and path.block[at - 1] == line else "moves nothing"
    x, y, z = np.round(path.tip[at] * 1e3, 4) + 0.0
    said = f"goes to X{x:g} Y{y:g} Z{z:g} mm of the part"
    i, j, k = path.axis[at]
    if k < 1.0 - ALIKE:
        said += f" with the tool along {i:.4g}, {j:.4g}, {k:.4g}"
    if path.rapid[at]:
        return said + " in rapid"
    if np.isfinite(path.feed[at]):
        return said + f" at {path.feed[at] * 6e4:.5g} mm/min"
    return said + (f" in {path.least_time[at]:.4g} s" if path.least_time[at] else "")


def _dwells(path: ToolPath) -> dict[int, float]:
    """Line to the time that is waited at the ends of its motions [s], each time that it is executed."""
    lines, at = np.unique(path.block, return_inverse=True)
    waited = np.bincount(at, path.dwell)
    return {int(line): float(time) for line, time in zip(lines, waited, strict=True) if time > 0.0}


def _line_of_dwell(path: ToolPath, source: Source, line: int) -> int:
    """The line of G4 behind that of the motion at whose end a path waits; that line, where there is none."""
    behind = path.block[path.block > line]
    last = int(behind.min()) if len(behind) else len(source.lines) + 1
    return next((n for n in range(line, last) if _DWELL.search(source.lines[n - 1])), line)


def _waits(seconds: float) -> str:
    return f"waits {seconds:.4g} s" if seconds else "does not wait"


def thinned(source: Source) -> Source:
    """The program without most plain straight motions, its lines at their numbers.

    Between two blocks that are not plain motions, the first of each kind are kept: the same letters, G and F. Arcs are
    plain, but all kept. What controls read differently they read differently in these too, but for what depends
    on figures of straight motions alone.
    """
    jumps = any(map(_JUMPS.search, source.lines))
    seen: Counter[tuple[str, ...]] = Counter()
    lines = []
    for line in source.lines:
        plain = PLAIN.fullmatch(line)
        if plain is None:
            seen.clear()
        elif plain[2]:
            kind = tuple(_LETTERS.findall(plain[2]))
            seen[kind] += 1
            if seen[kind] > KEPT and not {"I", "J", "K"} & set(kind):
                lines.append((plain[1] or "") if jumps else "")
                continue
        lines.append(line)
    return dataclasses.replace(source, lines=tuple(lines), data=b"")
