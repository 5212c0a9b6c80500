"""Variables: R parameters, program variables, system variables."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from toolpace.common.units import MILLIMETRE
from toolpace.programs.reading.coordinates.affine import Matrix
from toolpace.programs.reading.expressions import BlockError, half_away_from_zero
from toolpace.programs.reading.sinumerik.syntax.expressions import r_number
from toolpace.programs.reading.sinumerik.syntax.values import (
    Axis,
    Row,
    Unread,
    Value,
    real,
    shown,
    whole,
)

LARGEST_INT = (1 << 31) - 1
MOST_ELEMENTS = 100_000
"""Elements of one array."""
MOST_DIMENSIONS = 3
MOST_OF_ROW = 1000
"""Elements that one block gives values, lest loops take long."""
START: Mapping[str, Value] = {"REAL": 0.0, "INT": 0, "BOOL": False, "CHAR": 0, "STRING": "", "AXIS": Axis("X")}
Local = dict[str, "Variable"]
IDENTITY: Matrix = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


class Variable:
    """One variable: its type, the sizes of an array, and its values by index."""

    def __init__(self, kind: str, sizes: tuple[int, ...] = ()) -> None:
        elements = 1
        if len(sizes) > MOST_DIMENSIONS:
            raise BlockError(f"an array of {len(sizes)} dimensions cannot be (alarm 12190): write at most 3")
        for size in sizes:
            elements *= size
            if not 0 < size <= MOST_ELEMENTS or elements > MOST_ELEMENTS:
                raise BlockError(f"an array of {size} elements cannot be: write a size from 1 to {MOST_ELEMENTS}")
        self.kind, self.sizes = kind, sizes
        self.values: dict[tuple[int, ...], Value] = {}

    def get(self, index: tuple[int, ...], name: str) -> Value:
        """The value of an element."""
        self._check(index, name)
        found = self.values.get(index)
        if found is None:
            return IDENTITY if self.kind == "FRAME" else START[self.kind]
        return found

    def set(self, index: tuple[int, ...], value: Value, name: str) -> None:
        """Give an element a value of the variable's type, or it and those behind it the values of a row."""
        self._check(index, name)
        if not isinstance(value, Row):
            self.values[index] = converted(value, self.kind, name)
            return
        begin, elements = 0, math.prod(self.sizes)
        for place, size in zip(index, self.sizes):
            begin = begin * size + place
        count = elements - begin if value.repeated else len(value.values)
        if count > elements - begin:
            raise BlockError(f"{name} has {elements - begin} elements from there on, not {count}: correct them")
        if count > MOST_OF_ROW:
            raise BlockError(f"SET and REP give {MOST_OF_ROW} elements at most here, not {count}: write a loop")
        for k in range(count):
            each = converted(value.values[0 if value.repeated else k], self.kind, name)
            self.values[self._place(begin + k)] = each

    def _place(self, number: int) -> tuple[int, ...]:
        """Indices of an element by its number; the last index runs first."""
        found: list[int] = []
        for size in reversed(self.sizes):
            number, index = divmod(number, size)
            found.insert(0, index)
        return tuple(found)

    def _check(self, index: tuple[int, ...], name: str) -> None:
        if len(index) != len(self.sizes):
            raise BlockError(f"{name} has {len(self.sizes)} indices, not {len(index)}: correct it")
        for value, size in zip(index, self.sizes):
            if not 0 <= value < size:
                raise BlockError(f"{name}[{value}] does not exist, its elements are 0 to {size - 1}: correct it")


def converted(value: Value, kind: str, name: str) -> Value:
    """A value as one of a type: an INT is rounded as ROUND does it, a BOOL is whether it is not zero (Job Planning,
    "Possible type conversions")."""
    if kind == "REAL":
        return float(real(value))
    if kind in ("INT", "CHAR"):
        whole_number = int(half_away_from_zero(real(value)))
        if not -LARGEST_INT - 1 <= whole_number <= LARGEST_INT:
            raise BlockError(f"{name} is of type {kind} and cannot be {whole_number}: correct it")
        return whole_number
    if kind == "BOOL":
        return bool(real(value))
    fits = {"STRING": isinstance(value, str), "AXIS": isinstance(value, Axis)}
    if fits.get(kind, isinstance(value, tuple) and not isinstance(value, Axis)):
        return value
    raise BlockError(f"{name} is of type {kind} and cannot be {shown(value)}: correct it")


class Store:
    """All variables that a block can see."""

    def __init__(self, preset: Mapping[str, float], system: Callable[[str, tuple[Value, ...]], Value]) -> None:
        self.r: dict[int, float] = {}
        self.unit = MILLIMETRE
        self.literals: tuple[float, ...] = ()
        self.preset = {name.upper(): value for name, value in preset.items()}
        self.local: Local = {}
        self._system = system
        for name, value in self.preset.items():
            if name[:1] == "R" and name[1:].isdecimal():
                self.r[int(name[1:][:6])] = value

    def variable(self, name: str, index: tuple[int, ...]) -> Value:
        """A variable of the program, or one of the set-up sheet. Raises Unread."""
        found = self.local.get(name)
        if found is not None:
            return found.get(index, name)
        if name in self.preset and not index:
            return self.preset[name]
        raise Unread(name, "it is neither defined here nor on the set-up sheet: write DEF, or name it there")

    def letter(self, name: str) -> Value:
        """A variable of one letter, else the axis."""
        return self.variable(name, ()) if name in self.local else Axis(name)

    def system(self, name: str, index: tuple[Value, ...]) -> Value:
        """A variable of the control. Raises Unread."""
        if name in self.preset:
            return self.preset[name]
        return self._system(name, index)

    def assign(self, name: str, index: tuple[Value, ...], value: Value) -> None:
        """Set R[i] or a variable of the program."""
        if name == "R":
            self.r[r_number(index[0])] = real(value)
            return
        found = self.local.get(name)
        if found is None:
            if name in self.preset and not index:
                self.preset[name] = real(value)
                return
            raise Unread(f"{name}=", "it is not defined: write DEF before it, or correct its name")
        found.set(tuple(map(whole, index)), value, name)

    def define(self, name: str, kind: str, sizes: tuple[int, ...] = ()) -> Variable:
        """A new variable, in place of one of that name."""
        made = Variable(kind, sizes)
        self.local[name] = made
        return made
