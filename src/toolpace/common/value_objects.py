"""What value objects share: a `repr` of one line, and equality by value for those that hold arrays."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import Field
from typing import Any, ClassVar

import numpy as np

LONGEST = 120
"""Most characters of a line."""
LONGEST_NAMES = 40
"""Most characters of a list of names in it."""


def one_line(thing: object, *parts: str) -> str:
    """`<Class part, part, ...>`, no longer than a line; parts that are empty are left out.

    Names come from files and callers: what cannot be printed is shown as `?`, and never moves a terminal's cursor.
    """
    text = ", ".join(part for part in parts if part)
    line = f"{type(thing).__name__} {text}" if text else type(thing).__name__
    printed = "".join(c if c.isprintable() else "?" for c in line)
    return f"<{shortened(printed, LONGEST - 2)}>"


def named(joints: Sequence[str]) -> str:
    """How many joints, and which: "5 joints X Y Z A C"."""
    return f"{counted(len(joints), 'joint')} {shortened(' '.join(joints), LONGEST_NAMES)}"


def counted(count: int, noun: str) -> str:
    """ "1 run", "3 runs"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def shortened(text: str, most: int) -> str:
    """The text, or as much of it as fits, and three dots."""
    return text if len(text) <= most else text[: most - 3] + "..."


class ByValue:
    """Frozen dataclasses (declared with eq=False) that are equal where they hold the same figures, and hash alike.

    The rule of the library: what is a set of figures (limits, set-points, a tool path, a machine, a motion, a verdict)
    is compared by value, here; what holds functions or compiled laws (paths, runs, laws, trajectories) is equal to
    itself alone, by eq=False without this class. Neither `==` nor `hash` ever raises.

    Equal are objects of the same class whose fields are equal, but for those declared with compare=False. Arrays are
    equal with the same shape and elements; nan is equal to nan here, as a figure that is missing in both.
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        # one field after the other: the first that differs decides
        return all(_key(getattr(self, name)) == _key(getattr(other, name)) for name in self._compared())

    def __hash__(self) -> int:
        return hash((type(self), *(_key(getattr(self, name)) for name in self._compared())))

    @classmethod
    def _compared(cls) -> list[str]:
        return [name for name, field in cls.__dataclass_fields__.items() if field.compare]


def _key(value: object) -> Hashable:
    """Something hashable that stands for a value: two keys are equal where the values are."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        if value.dtype.kind in "biu":
            return value.shape, value.astype(np.int64).tobytes()
        figures = np.array(value, dtype=float)
        figures += 0.0  # -0.0 becomes 0.0, its equal
        np.copyto(figures, np.nan, where=np.isnan(figures))
        return figures.shape, figures.tobytes()
    if isinstance(value, float) and value != value:
        return float, "nan"
    if isinstance(value, list | tuple):
        return tuple(map(_key, value))
    if isinstance(value, dict):
        return frozenset((key, _key(item)) for key, item in value.items())
    record = getattr(type(value), "__struct_fields__", None)
    if record is not None:
        return type(value), tuple(_key(getattr(value, name)) for name in record)
    try:
        hash(value)
    except TypeError:
        return id(value)
    return value
