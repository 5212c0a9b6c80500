"""Words of motion blocks: coordinates, feed, sense, compensation, M functions."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.parameters import Parameters, Value, evaluate, number

VALUE = r"[-+]?(?:[0-9]++[.,]?[0-9]*+|[.,][0-9]++|Q[LR]?[0-9]++)"
_WORD = re.compile(
    r"\s*(?:(F\s*MAX(?!T)|F\s*AUTO|MAX|RL|RR|R0(?![0-9.,])|R[-+](?![0-9.,Q])|DR\s*[-+](?![0-9.,Q]))"
    r"|(I?P[RA]|CCA|LEN|MB|LA|DR2|D[LR]|I?[A-CU-Z]|[NT][XYZ]|FMAXT|F[UZT]|[EFMRST])\s*(" + VALUE + r")?)"
)
AXES = frozenset("XYZABCUVW")
OWN_WORDS: dict[int, tuple[str, ...]] = {
    94: tuple("ABCUVW"),
    103: ("F",),
    112: ("T", "A", "E"),
    114: (),
    118: tuple("XYZABCUVW"),
    120: ("LA",),
    124: ("T",),
    128: ("F",),
    138: tuple("ABC"),
    140: ("MB", "F", "MAX"),
}
"""Words that belong to an M function where they stand behind it."""


@dataclass
class Function:
    """An M function and its own words."""

    code: Value
    words: dict[str, Value | None] = field(default_factory=dict)


@dataclass
class PathWords:
    """The words of one block."""

    axes: list[tuple[str, bool, Value]] = field(default_factory=list)
    """Letter, whether incremental, value."""
    others: dict[str, Value] = field(default_factory=dict)
    """PR, PA, R, LEN, CCA, NX ... by name."""
    feed: Value | None = None
    feed_word: str = ""
    """F, FMAX, FAUTO, FU, FZ, FT, FMAXT, or "" where the block has none."""
    sense: int = 0
    """1 for DR+ (counter-clockwise), -1 for DR-."""
    side: str = ""
    """R0, RL, RR, R+, R-."""
    functions: list[Function] = field(default_factory=list)


def signed(text: str, parameters: Parameters) -> Value:
    """A number, or a Q parameter with its sign. Raises BlockError."""
    if "Q" not in text:
        return number(text)
    get, name = parameters.get, text.lstrip("+-")
    if text.startswith("-"):
        return lambda: -get(name)
    return lambda: get(name)


def path_words(text: str, parameters: Parameters) -> PathWords:
    """The words behind the name of a block. Raises BlockError."""
    found = PathWords()
    at = 0
    while at < len(text):
        match = _WORD.match(text, at)
        if match is None:
            rest = text[at:].strip()
            if not rest:
                break
            raise BlockError(f"'{rest[:20]}' is not read here: check its spelling")
        at = match.end()
        if match[1]:
            _bare(found, "".join(match[1].split()))
        else:
            _valued(found, match[2], None if match[3] is None else signed(match[3], parameters))
    return found


def _bare(found: PathWords, word: str) -> None:
    last = found.functions[-1] if found.functions else None
    if word == "MAX" and last is not None and last.code == 140.0:
        last.words["MAX"] = None
    elif word in ("FMAX", "FAUTO"):
        found.feed_word = word
    elif word.startswith("DR"):
        found.sense = 1 if word[-1] == "+" else -1
    elif word[0] == "R":
        found.side = word
    else:
        raise BlockError(f"'{word}' is not read here: check its spelling")


def _valued(found: PathWords, name: str, value: Value | None) -> None:
    last = found.functions[-1] if found.functions else None
    if last is not None and isinstance(last.code, float) and name in OWN_WORDS.get(int(last.code), ()):
        last.words[name] = value
    elif value is None:
        if name not in ("R", "M", "F", "MB"):  # empty words of old posts say nothing
            raise BlockError(f"{name} has no value: write one behind it, or leave it out")
    elif name == "M":
        found.functions.append(Function(value))
    elif name.removeprefix("I") in AXES:
        found.axes.append((name[-1], len(name) == 2, value))
    elif name[0] == "F":
        found.feed, found.feed_word = value, name
    elif name in found.others:
        raise BlockError(f"{name} stands twice in one block: remove one")
    else:
        found.others[name] = value


def code_of(function: Function) -> int:
    """Number of an M function. Raises BlockError, UnsetError."""
    value = evaluate(function.code)
    if value != int(value) or not 0 <= value < 10000:
        raise BlockError(f"M{value:g} is no M function: it has a whole number")
    return int(value)
