"""The values of a block's words at execution, and how they are meant."""

from __future__ import annotations

from typing import NamedTuple

from toolpace.programs.reading.control.control import FARTHEST
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.syntax.blocks import Block
from toolpace.programs.reading.sinumerik.syntax.values import Memory, Value, real, shown


class WordValue(NamedTuple):
    """A value and its form: AC, IC, DC, ACP, ACN or none."""

    value: Value
    form: str = ""
    indices: tuple[Value, ...] = ()


Words = dict[str, WordValue]


def number(words: Words, address: str, default: float | None = None) -> float | None:
    """Take a number out of the words; the default where it is not there. Raises BlockError where it is a distance."""
    found = words.pop(address, None)
    if found is None:
        return default
    if found.form not in ("", "AC"):
        raise BlockError(f"{address}={found.form}() has no meaning: {address} takes a value as it is")
    return bounded(found, address)


def check_settled(words: Words, block: Block, memory: Memory) -> None:
    """BlockError where a word has another value behind the assignments of its block: which is first is not told."""
    for word in block.words:
        found = words.get(word.address)
        if found is not None and word.compiled is not None and word.compiled(memory) != found.value:
            raise BlockError(
                f"{word.address} reads what its own block assigns: which of them is first is not told; write two blocks"
            )


def bounded(word: WordValue, address: str) -> float:
    """The number of a word. Raises BlockError."""
    value = real(word.value)
    if not abs(value) <= FARTHEST:
        raise BlockError(f"{address} is beyond {FARTHEST:g}: correct the number")
    return value


class Arguments:
    """Arguments of a cycle by their place; what is left out is zero."""

    def __init__(self, name: str, values: list[Value | None], most: int) -> None:
        if len(values) > most:
            raise BlockError(f"{name} takes at most {most} arguments, not {len(values)}: correct them")
        self.name, self.values = name, values

    def has(self, place: int) -> bool:
        """Whether the argument of a place, from 0, is there."""
        return place < len(self.values) and self.values[place] is not None

    def number(self, place: int, default: float = 0.0) -> float:
        """The number of a place."""
        value = self.values[place] if place < len(self.values) else None
        if value is None:
            return default
        found = real(value)
        if not abs(found) <= 1e9:
            raise BlockError(f"argument {place + 1} of {self.name} is beyond 1e9: correct it")
        return found

    def code(self, place: int, default: int = 0) -> int:
        """The whole number of a place."""
        found = self.number(place, default)
        if found != round(found):
            raise BlockError(f"argument {place + 1} of {self.name} must be a whole number, not {found:g}")
        return round(found)

    def text(self, place: int) -> str:
        """The text of a place."""
        value = self.values[place] if place < len(self.values) else None
        if value is None or isinstance(value, str):
            return value or ""
        raise BlockError(f'argument {place + 1} of {self.name} must be a text, like "TC1", not {shown(value)}')
