"""The Q parameters of a running program."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from toolpace.programs.reading.language.expressions import BlockError as BlockError

LARGEST = 1e9
"""Beyond which a value is a slip: no machine travels so far."""

MOST = {"Q": 1999, "QL": 499, "QR": 499}
"""Highest number of a parameter of each kind (TNC 640 Klartext, "Q parameters", "Overview of functions")."""


class UnsetError(Exception):
    """A parameter is read that has no value; the message is its name, "" where it hangs on another that has none."""


class Parameters:
    """Values of Q (of all programs), QR (kept), QL (of one program) and texts QS."""

    def __init__(self, given: Mapping[str, float]) -> None:
        self.shared: dict[str, float] = {name.upper(): value for name, value in given.items()}
        self.local: dict[str, float] = {}
        self.texts: dict[str, str] = {}
        self.hanging: set[str] = set()
        """Names whose value hangs on parameters that have none."""

    def get(self, name: str) -> float:
        """Value of Q5, QL5 or QR5. Raises UnsetError."""
        values = self.local if name.startswith("QL") else self.shared
        try:
            return values[name]
        except KeyError:
            raise UnsetError("" if name in self.hanging else name) from None

    def assign(self, name: str, value: Callable[[], float]) -> None:
        """Give it the value of a formula. Raises BlockError, UnsetError: then it has none from there on."""
        try:
            self.set(name, value())
        except UnsetError:
            self.forget(name)
            raise

    def forget(self, name: str) -> None:
        """Take it for one whose value hangs on what is not known."""
        (self.local if name.startswith("QL") else self.shared).pop(name, None)
        self.hanging.add(name)

    def set(self, name: str, value: float) -> None:
        """Give it a value. Raises BlockError where that is none."""
        if not math.isfinite(value):
            raise BlockError(f"{name} would become {value:g}: check the figures of the formula")
        (self.local if name.startswith("QL") else self.shared)[name] = value

    def text(self, name: str) -> str:
        """Text of QS5. Raises UnsetError."""
        try:
            return self.texts[name]
        except KeyError:
            raise UnsetError(name) from None


def named(name: str) -> str:
    """The name of a parameter that a block sets. Raises BlockError where the control has none of that number."""
    kind = name.rstrip("0123456789")
    if int(name[len(kind) :]) > MOST[kind]:
        raise BlockError(f"{name} is no parameter: {kind} are numbered from 0 to {MOST[kind]}")
    return name


def number(text: str) -> float:
    """A number of a program, with point or comma. Raises BlockError."""
    value = float(text.replace(",", "."))
    if not abs(value) <= LARGEST:
        raise BlockError(f"{text[:20]} is beyond any machine (at most 1e9): check its digits")
    return value
