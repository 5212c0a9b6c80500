"""Words of a line, without its comments: their letters and numbers, and what G and M words mean to a controller.

What numbers without a point may count, and what values of expressions are rounded to, are the least increments of the
increment system IS-B, which both Fanuc ("Increment system") and Haas ("ROUND") have by default.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NamedTuple

from toolpace.common.errors import UsageError
from toolpace.common.units import INCH
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.expressions import BlockError

NUMBER = r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)"
_WORD = re.compile(rf"([A-Z])[ \t]*({NUMBER})")
_BLOCK = re.compile(rf"[ \t]*(?:[A-Z][ \t]*{NUMBER}[ \t]*)*+")
_DECIMAL_COMMA = re.compile(r"[A-Z=][ \t]*[-+]?([0-9]*),([0-9]+)")
_COMMENT = re.compile(r"\([^()]*\)")
_NAME = re.compile(r"[A-Z_][A-Z_]+")


Numbers = dict[str, float]
"""Values of the words of a block, by letter."""
Handler = Callable[[Numbers, str], None]
"""Carries out a word: takes what belongs to it out of the numbers of the block."""


NO_EXPONENT = (
    "E has no meaning here: write numbers without exponent, like 0.00001 (extruders of printers are not read)"
)
ROUND_HANDED_OVER = (
    "ROUND in an argument of a macro",
    "it may round to whole numbers or to least increments: set a variable to it in a block before",
)
"""A word that is refused, and the cure."""
LARGEST = 1e21
"""Most of a number: more is a slip, and would end as infinity; the tangent of 90 degrees is less."""


LENGTHS = frozenset("XYZABCUVWIJRQ")
"""Letters whose numbers are lengths or angles, and may count least increments where they have no point."""
ROUNDED = frozenset("XYZABCUVW")
"""Axis words: "the value of a variable referenced is automatically rounded according to the least input increment of
the address" (B-63944EN, "Variables"; Haas has its own example, "ROUND")."""
OF_ARCS = frozenset("IJKR")
"""Those of an arc, which count as axis words do."""
_ANGLE, _IN_INCHES = 0.001, 0.0001
_HALF = 0.5 + 1e-9
"""Decimal halves are rounded up, though their binary numbers lie a little below."""


class RefusedError(BlockError):
    """A word that may move something and is not read: the rest of the program can be."""

    def __init__(self, word: str, cure: str) -> None:
        self.word, self.cure = word, cure
        super().__init__(f"{word} is not read: {cure}")


def without_comments(line: str, nested: bool = False, closed: bool = False) -> str:
    """The block in capitals, without `( )` and `;` comments and outer blanks.

    nested: comments may hold comments, and one that is open at the end of the line ends there.
    closed: that one is an error. Raises BlockError.
    """
    if "(" in line or ")" in line or ";" in line:
        semicolon = line.find(";")
        if semicolon >= 0 and "(" not in line[:semicolon]:
            line = line[:semicolon]
        if nested:
            line = _outside(line, closed)
        else:
            line = _COMMENT.sub(" ", line)
        line = line.split(";", 1)[0]
        if "(" in line or ")" in line:
            raise BlockError("a comment's bracket has no partner: close the comment on its line, and do not nest them")
    return line.upper().strip()


def _outside(line: str, closed: bool) -> str:
    kept: list[str] = []
    depth, opened = 0, False
    for piece in re.split(r"([();])", line):
        if piece == ";" and not depth:
            break
        if piece == "(":
            depth, opened = depth + 1, True
        elif piece == ")" and depth:
            depth, opened = depth - 1, False
            kept.append(" ")
        elif not depth:
            kept.append(piece)
    if opened and closed:
        raise BlockError("the comment is open at the end of its line, and may hide all up to the next ): close it")
    return "".join(kept)


def bounded(value: float) -> float:
    """The value; BlockError where it is no number, or too large for one."""
    if not -LARGEST <= value <= LARGEST:
        raise BlockError(f"the number {value:g} is too large for any meaning: correct it")
    return value


def near_whole(value: float, near: float) -> float:
    """The whole number that a value is nearer to than `near`, as posts round; else the value."""
    whole = math.floor(value + 0.5) if abs(value) <= LARGEST else value
    return float(whole) if abs(value - whole) < near else value


def plain_words(block: str) -> list[tuple[str, str]] | None:
    """Letters and the texts of their numbers, in order; None where the block is more than that."""
    match = _BLOCK.match(block)
    if match is None or match.end() != len(block):
        return None
    return _WORD.findall(block)


def words_behind(line: str) -> bool:
    """Whether there are words behind a `;`, which ends a block in listings of some controllers."""
    rest = line.split(";", 1)[1].strip().upper()
    return bool(rest and plain_words(rest))


def decimal_comma(text: str) -> str:
    """What to write for the first number of a text that has a comma for its point; empty where none has."""
    found = _DECIMAL_COMMA.search(text)
    return "" if found is None else f"'{found[0]}' has a decimal comma: write {found[0].replace(',', '.')}"


def fault(block: str) -> str:
    """What is wrong with a block from a place on at which no word begins."""
    match = _BLOCK.match(block)
    rest = block[match.end() :] if match else block
    name = _NAME.match(rest)
    if name and not re.match(r"[A-Z]E[-+]?[0-9]", rest):
        return (
            f"'{name[0][:20]}' is no letter with a number, and might move something: "
            "G-code words are read, like X1.5; conversational and other control languages are not"
        )
    if rest[:1].isalpha() and rest[:1].isascii():
        return f"letter {rest[0]} has no number after it: write one, like {rest[0]}1.5"
    if rest[:1] and rest[0] in "+-.0123456789":
        return f"number '{rest.split()[0][:20]}' has no letter before it: write it like X1.5"
    if rest.strip() == "*":
        return "'*' ends blocks of Heidenhain's DIN/ISO, which is not read: convert it to Klartext on the control"
    return f"'{rest[:1]}' has no meaning in G-code: remove it, or write it as a comment in ( )"


def increment(letter: str, unit: float) -> float:
    """Least increment of a word, in the unit it is written in: mm or inch (`unit` [m]), degrees, mm or inch a minute;
    of all that count something 1."""
    inch = unit == INCH
    if letter in "ABC":
        return _ANGLE
    if letter in LENGTHS or letter == "K":
        return _IN_INCHES if inch else 0.001
    return 0.01 if letter == "F" and inch else 1.0


def rounded(value: float, step: float) -> float:
    """The multiple of `step` next to a value, of two as near the one farther from zero."""
    return math.copysign(math.floor(abs(value) / step + _HALF), value) * step


# Meanings

GROUPS: dict[str, tuple[str, ...]] = {
    "saved modes": ("save modes", "save modes for return", "forget modes", "restore modes"),
    "feed mode": ("inverse time", "feed per minute", "feed per revolution"),
    "unit": ("inch", "millimetre"),
    "function": (
        "stop", "turn spindle", "orient spindle", "wait for input", "unknown function", "tool change", "tool at hand",
        "tip mode on", "tip mode off",
    ),
    "plane": ("plane XY", "plane ZX", "plane YZ"),
    "distance": ("absolute", "incremental"),
    "arc centre": ("arc centre absolute", "arc centre incremental"),
    "path": ("exact stop mode", "continuous path"),
    "compensation": ("compensation", "compensation by diameter", "compensation off"),
    "offset": ("work offset", "numbered offset", "no offset"),
    "length": (
        "tool length", "told offset", "added offset", "tip mode", "tip mode that stands", "tool vector mode",
        "length off", "tip mode ends",
    ),
    "retract": ("to initial level", "to R level"),
    "polar": ("polar", "cartesian"),
    "scale": ("scale", "scale off"),
    "mirror": ("mirror", "mirror off"),
    "rotation": (
        "rotate", "tilt plane", "tilt plane upon plane", "plane of tool", "tilt plane by order", "carried frame",
        "rotation off",
    ),
    "action": (
        "dwell", "reference", "second reference", "from reference", "set offset", "local shift", "set position",
        "clear position", "suspend position", "restore position", "turn to plane", "turn to plane about tip",
        "macro call", "hole circle", "hole arc", "modal macro call", "modal macro off", "only off",
        "datum", "datum added", "tilt by axes", "machine rapid", "run cycle",
        "end of data", "limits", "settings", "no motion",
        "define drill", "define peck", "define tap", "define bore", "define bore and stop",
    ),
    "machine coordinates": ("machine coordinates",),
    "exact stop": ("exact stop",),
    "end of cycle": ("end cycle",),
    "motion": (
        "rapid", "feed", "arc clockwise", "arc counter-clockwise", "drill", "drill and dwell", "peck",
        "break chips", "tap", "bore", "bore and dwell", "bore and stop", "bore and orient", "bore backwards",
        "bore by hand", "cubic spline", "quadratic spline", "nurbs", "nurbs by knots", "end of nurbs",
    ),
    "call": ("call program", "call here", "return"),
    "ends": ("program stop", "end"),
}  # fmt: skip
"""Groups in the order in which a controller acts on them; words of one exclude each other in a block."""
ORDER = {meaning: order for order, group in enumerate(GROUPS.values()) for meaning in group}
GROUP_OF = {meaning: group for group, meanings in GROUPS.items() for meaning in meanings}
UNKNOWN_G = "it is not known here and might move something: remove it, or let the CAM system write plain G0 to G3"
UNKNOWN_M = "it is not known here and might move something: remove it, or write what it does as plain blocks"
_TAKEN_TOGETHER = ("function", "action", "call", "ends")
"""Groups whose words do something once, in place of setting a mode."""
_TOGETHER = (("M3", "M4", "M5", "M19"), ("M7", "M9"), ("M8", "M9"))
"""Functions of which one block has one, beside those that end or call."""


class Action(NamedTuple):
    """A G or M word in a block, and what it means."""

    meaning: str
    word: str


class Vocabulary:
    """The words of one controller."""

    def __init__(self, controller: Controller) -> None:
        """Raises UsageError where the controller's file names a meaning that there is not."""
        self.meanings = controller.meanings
        self.ignored = frozenset(controller.ignored)
        self.refused = controller.refused
        self.unknown_stops = controller.option("unknown_m_stops", False)
        for word, meaning in self.meanings.items():
            if meaning not in GROUP_OF:
                raise UsageError(
                    f"{controller.source or controller.name}: {word[:40]} = '{meaning[:40]}' is no meaning that is "
                    f"known: use one of {', '.join(GROUP_OF)}"
                )

    def of(self, letter: str, value: float) -> Action | str | None:
        """What a word does; the cure where it is refused; None where it moves nothing."""
        word = f"{letter}{value:.12g}"
        meaning = self.meanings.get(word)
        if meaning is not None:
            return Action(meaning, word)
        if word in self.ignored:
            return None
        cure = self.refused.get(word)
        if cure is not None:
            return cure
        if letter == "G":
            return UNKNOWN_G
        if self.unknown_stops and value == int(value) and 0 <= value < 1000:
            return Action("unknown function", word)
        return UNKNOWN_M


def last_of_groups(actions: list[Action]) -> list[Action]:
    """The words of a block where, of those that set one mode, the last rules."""
    last = {GROUP_OF[meaning]: k for k, (meaning, _) in enumerate(actions)}
    return [
        action for k, action in enumerate(actions)
        if GROUP_OF[action.meaning] in _TAKEN_TOGETHER or last[GROUP_OF[action.meaning]] == k
    ]  # fmt: skip


def conflict(actions: list[Action]) -> str:
    """Why words cannot stand in one block; empty where they can."""
    seen: dict[str, str] = {}
    words = {action.word for action in actions}
    for meaning, word in actions:
        group = GROUP_OF[meaning]
        if group != "function" and seen.setdefault(group, word) != word:
            return f"{seen[group]} and {word} exclude each other in one block: write two blocks"
    for group_of_words in _TOGETHER:
        both = [word for word in group_of_words if word in words]
        if len(both) > 1:
            return f"{both[0]} and {both[1]} exclude each other in one block: write two blocks"
    return ""
