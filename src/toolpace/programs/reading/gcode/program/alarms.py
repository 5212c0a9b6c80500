"""Alarms of LinuxCNC's interpreter at blocks that could be understood.

After its source (2.9: interp_read.cc, interp_check.cc, interp_array.cc) and "G Code Modal Groups" of its manual. A
block whose meaning is not certain is an error of its own, and none of these.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Set
from typing import NamedTuple

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program.words import NO_EXPONENT

LONGEST_LINE = 252
"""Characters of a line, without its end ("Command too long")."""
GROUPS: dict[str, tuple[str, ...]] = {
    "motion": (
        *("G0", "G1", "G2", "G3", "G5", "G5.1", "G5.2", "G33", "G33.1", "G38.2", "G38.3", "G38.4", "G38.5", "G73"),
        *("G74", "G76", "G81", "G82", "G83", "G84", "G85", "G86", "G87", "G88", "G89"),
    ),
    "done once": ("G4", "G5.3", "G10", "G28", "G28.1", "G30", "G30.1", "G52", "G53", "G92"),
    "position": ("G92.1", "G92.2", "G92.3"),
    "plane": ("G17", "G18", "G19"),
    "distance": ("G90", "G91"),
    "arc distance": ("G90.1", "G91.1"),
    "feed mode": ("G93", "G94", "G95"),
    "unit": ("G20", "G21"),
    "compensation": ("G40", "G41", "G41.1", "G42", "G42.1"),
    "length": ("G43", "G43.1", "G43.2", "G49"),
    "offset": ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"),
    "path": ("G61", "G61.1", "G64"),
    "return": ("G98", "G99"),
    "spindle mode": ("G96", "G97"),
    "diameter": ("G7", "G8"),
    "stop": ("M0", "M1", "M2", "M30", "M60", "M99"),
    "inputs and outputs": ("M62", "M63", "M64", "M65", "M66", "M67", "M68"),
    "tool": ("M6", "M61"),
    "spindle and saved modes": ("M3", "M4", "M5", "M19", "M70", "M71", "M72", "M73"),
    "coolant": ("M7", "M8", "M9"),
    "override": ("M48", "M49", "M50", "M51", "M52", "M53"),
}
"""Modal groups: a block has one word of each."""
GROUP_OF = {word: group for group, words in GROUPS.items() for word in words}
OWN = frozenset((*GROUP_OF, "G80", "M98"))
"""Words of LinuxCNC itself; what others mean a block's letters for is theirs."""
MOTIONS = frozenset((*GROUPS["motion"], "G80"))
WITH_AXES = frozenset(("G10", "G28", "G30", "G52", "G92"))
"""Words that take the axes of their block for themselves: no motion stands beside them."""
AXES = frozenset("XYZABCUVW")
PLAIN = AXES | frozenset("FST")
"""Letters of which nothing is to be asked."""
_CYCLES = ("G73", "G74", "G81", "G82", "G83", "G84", "G85", "G86", "G87", "G88", "G89")
_ARCS = ("G2", "G3")
USERS: dict[str, tuple[str, ...]] = {
    "D": ("G41", "G42", "G41.1", "G42.1", "G96"),
    "E": ("G33", "G33.1", "G76", "M66", "M67", "M68"),
    "H": ("G43", "G43.2", "G76"),
    "I": (*_ARCS, "G5", "G5.1", "G10", "G33.1", "G76", "G87"),
    "J": (*_ARCS, "G5", "G5.1", "G10", "G76", "G87"),
    "K": (*_ARCS, "G33", "G33.1", "G76", "G87"),
    "L": (*_CYCLES[2:], "G73", "G76", "G5.2", "G10", "G41", "G42", "G41.1", "G42.1", "M66", "M98"),
    "P": (
        *("G4", "G10", "G64", *_ARCS, "G5", "G5.2", "G74", "G76", "G82", "G84", "G86", "G88", "G89"),
        *("M19", "M50", "M51", "M52", "M53", "M62", "M63", "M64", "M65", "M66", "M98"),
    ),
    "Q": ("G5", "G10", "G64", "G73", "G76", "G83", "M19", "M61", "M66", "M67", "M68"),
    "R": (*_ARCS, *_CYCLES, "G76", "G10", "G41.1", "G42.1", "M19"),
}
"""Words that use a letter, in a block or as the motion in force."""
NEEDED = {"M62": "P", "M63": "P", "M64": "P", "M65": "P", "M67": "E", "M68": "E", "G96": "S"}
"""Letter without which a word is an error; those that move something ask for theirs where they are carried out."""
_OF_TOOLS = frozenset("DH")
"""Letters that move nothing wherever they stand."""
_MOVING = AXES | MOTIONS | WITH_AXES | {"G43.1"}
_WITHIN = re.compile(r"[A-Z.][ \t]*\0[ \t]*[-+.0-9\[#]|[0-9.][ \t]*\0[ \t]*[.0-9]")
_COMMENT = re.compile(r"\([^()]*\)")


class Alarm(NamedTuple):
    """Something that stops the control, and what to write."""

    what: str
    cure: str


def of_line(line: str) -> Iterator[Alarm]:
    """Of the length of a line, which counts where it is passed over too."""
    if len(line) > LONGEST_LINE:
        yield Alarm(f"a line of {len(line)} characters", f"{LONGEST_LINE} are the most: write it as several lines")


def of_text(text: str) -> Iterator[Alarm]:
    """Of N and / behind the beginning of a block (in capitals, without comments, its number and / before it)."""
    if "N" in text and re.search(r"N[ \t]*[0-9]", re.sub(r"<[^<>]*>", " ", text)):
        yield Alarm("N in the middle of a block", "it stands first, and once: remove the other")


def refuse_comment_in_word(line: str) -> None:
    """Raise BlockError where a comment stands between a letter and its number, or between digits."""
    if "(" in line and _WITHIN.search(_COMMENT.sub("\0", line.split(";", 1)[0].upper())):
        raise BlockError("a comment stands within a word: write it before or behind")


def of_codes(words: list[str]) -> Iterator[Alarm]:
    """Of two G or M words of one modal group. Raises BlockError where what the block does is not certain."""
    seen: dict[str, str] = {}
    for word in words:
        group = GROUP_OF.get(word, "")
        before = seen.get(group, "")
        if group and not before:
            seen[group] = word
        elif not group:
            continue
        elif before == word:
            yield Alarm(f"{word} twice in a block", "write it once")
        elif word[0] == "G":
            raise BlockError(f"{before} and {word} are of one modal group ({group}): write two blocks")
        else:
            yield Alarm(f"{before} and {word} in one block", f"both are of one modal group ({group}): write two blocks")
    covets = next((word for word in words if word in WITH_AXES or word in ("G43.1", "G43.2")), None)
    motion = next((word for word in words if word in MOTIONS and word != "G80"), None)
    if covets and motion:
        raise BlockError(f"{covets} and {motion} both take the axes of the block: write two blocks")
    if "G4" in words and any(word in _ARCS for word in words):
        raise BlockError("G4 and an arc both take P: write two blocks")


def of_letters(letters: Set[str], words: list[str], in_force: str) -> Iterator[tuple[str, Alarm]]:
    """Letters of a block that no word of it uses, each with its alarm; a letter that is missing stands as "".

    in_force: the motion in force (G1). Raises BlockError where the letter may have been meant for a motion.
    """
    if not OWN.issuperset(words):
        return
    present = {*words, motion(letters, words, in_force)}
    for letter in sorted(letters & USERS.keys()):
        users = USERS[letter]
        if present.isdisjoint(users):
            named = f"{', '.join(users[:-1])} or {users[-1]}"
            if letter == "E":
                raise BlockError(NO_EXPONENT)
            certain = letter in _OF_TOOLS or (words and in_force not in _CYCLES)
            if not certain or (letter not in _OF_TOOLS and not (present | letters).isdisjoint(_MOVING)):
                raise BlockError(f"{letter} has no use in this block, it belongs to {named}: remove it")
            yield letter, Alarm(f"{letter} without a word that uses it", f"it belongs to {named}: remove it")
    for word in words:
        if NEEDED.get(word, "S") not in letters and word in NEEDED:
            yield "", Alarm(f"{word} without {NEEDED[word]}", f"write it like {word} {NEEDED[word]}1")


def refuse_motionless(letters: Set[str], words: list[str], in_force: str) -> None:
    """Raise BlockError where G53 has neither G0 nor G1, or an arc no word of its centre."""
    present = motion(letters, words, in_force)
    if "G53" in words and present not in ("G0", "G1"):
        raise BlockError("G53 stands with G0 or G1: write it like G53 G0 Z0")
    if present in _ARCS and letters.isdisjoint(AXES | set("IJKR")):
        raise BlockError(f"{present} lacks its centre: write I, J or K, or R")


def motion(letters: Set[str], words: list[str], in_force: str) -> str:
    """The word of the motion that a block makes; "" where it makes none."""
    own = [word for word in words if word in MOTIONS]
    if own:
        return min(own, key=lambda word: word == "G80")  # beside another motion G80 counts for nothing
    if not WITH_AXES.isdisjoint(words):
        return ""
    if not letters.isdisjoint(AXES):
        return "" if "G43.1" in words else in_force
    return in_force if in_force in _ARCS and not letters.isdisjoint("IJK") else ""
