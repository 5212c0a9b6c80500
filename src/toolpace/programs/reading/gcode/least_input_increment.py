"""Numbers in least increments: those without a point that count them, and values of expressions rounded to them.

Without a point: Fanuc, parameter 3401#0 (DPI) = 0; Haas: Setting 162 and those of its kind are off.
"""

from __future__ import annotations

from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.gcode.holes import KINDS
from toolpace.programs.reading.gcode.modal import ARCS, Modal
from toolpace.programs.reading.gcode.program.blocks import Block
from toolpace.programs.reading.gcode.program.words import (
    LENGTHS,
    OF_ARCS,
    ROUNDED,
    Numbers,
    RefusedError,
    increment,
    rounded,
)

SECONDS = frozenset("XU")
_ANGLES: dict[str, frozenset[str]] = {
    "rotate": frozenset("R"),
    "tilt plane": frozenset("IJKR"),
    "tilt plane upon plane": frozenset("IJKR"),
    "tilt plane by order": frozenset("IJK"),
    "plane of tool": frozenset("R"),
    "hole circle": frozenset("J"),
    "hole arc": frozenset("JK"),
}
"""Letters that are angles, by the word that takes them."""
_PURE: dict[str, frozenset[str]] = {
    "tilt plane": frozenset("Q"),
    "tilt plane upon plane": frozenset("Q"),
    "tilt plane by order": frozenset("Q"),
    "rotate": frozenset("IJK"),
    "scale": frozenset("IJK"),
}
"""Letters that have no unit, or one that is told elsewhere."""
_UNITS = {"inch": INCH, "millimetre": MILLIMETRE}


def count_increments(numbers: Numbers, block: Block, state: Modal, repeats: str) -> None:
    """Multiply the numbers that have no point by what one counts. Raises RefusedError where that is not sure.

    repeats: the letter by which cycles count their holes.
    """
    whole = block.whole & (LENGTHS | {"K", ",R", ",C"})
    meanings = {action.meaning for action in block.actions}
    arc = state.motion in ARCS or not meanings.isdisjoint(ARCS)
    if state.vectors and not arc:
        whole = _without_vector(numbers, whole)
    angles = frozenset("ABC").union(*(_ANGLES.get(meaning, ()) for meaning in meanings))
    pure = frozenset[str]().union(*(_PURE.get(meaning, ()) for meaning in meanings)) - angles
    if repeats == "K" and (state.cycle is not None or not meanings.isdisjoint(KINDS)):
        pure |= {"K"}
    if state.polar or "polar" in meanings:
        angles |= {"YXZ"[state.plane]}
    if "dwell" in meanings:
        angles |= SECONDS  # thousandths of a second, in inches too
    unit = _unit(block, state)
    for letter in whole - pure:
        numbers[letter] *= increment("A" if letter in angles else letter.lstrip(","), unit)


def round_values(numbers: Numbers, block: Block, state: Modal) -> None:
    """Round the values of expressions that are places to the least increments of their words."""
    arc = state.motion in ARCS or any(action.meaning in ARCS for action in block.actions)
    unit = _unit(block, state)
    for letter, _ in block.computed:
        if letter in numbers and (letter in ROUNDED or (arc and letter in OF_ARCS)):
            numbers[letter] = rounded(numbers[letter], increment(letter, unit))


def _unit(block: Block, state: Modal) -> float:
    """The unit of the lengths of a block [m], which may tell it itself."""
    for action in block.actions:
        if action.meaning in _UNITS:
            return _UNITS[action.meaning]
    return state.unit


def _without_vector(numbers: Numbers, whole: frozenset[str]) -> frozenset[str]:
    """Of a tool vector only the direction counts, where all its numbers are written alike."""
    vector = {letter for letter in "IJK" if numbers.get(letter)}
    if vector & whole and not vector <= whole:
        raise RefusedError("a tool vector of which some numbers have a point", "write all of I, J, K with one")
    return whole - vector
