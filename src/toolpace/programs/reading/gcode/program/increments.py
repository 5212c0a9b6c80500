"""Least increments of words: what numbers without a point may count, and what values of expressions are rounded to.

They are those of the increment system IS-B, which both Fanuc ("Increment system") and Haas ("ROUND") have by default.
"""

from __future__ import annotations

import math

from toolpace.common.units import INCH

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
