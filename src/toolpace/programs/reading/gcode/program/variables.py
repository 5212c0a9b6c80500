"""Numbered and named variables of a program and of its calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program.words import RefusedError, bounded

Key = int | str


_ELSEWHERE = {"#<_hal[": "HAL of the machine", "#<_ini[": "the INI file of the machine"}


class UnsetError(RefusedError):
    """A variable is read that nothing has set."""

    def __init__(self, name: str) -> None:
        where = next((where for sign, where in _ELSEWHERE.items() if name.startswith(sign)), "")
        set_it = f"{where} has it, and the program is read without: " if where else "set it before it is read, or "
        super().__init__(name, f"{set_it}give it in [variables] of the set-up sheet")


class Variables:
    """Values by number or name; an empty one is None.

    locals_to: numbers from 1 to this belong to each call. empty_locals: they are empty where nothing set them.
    system_from: from this number on, below 10000, they are the controller's own, and so are names that begin with _
    and are not set by the program.
    """

    def __init__(
        self,
        preset: Mapping[str, float],
        system: Callable[[Key], float | None],
        *,
        locals_to: int,
        empty_locals: bool,
        system_from: int,
        letter: str = "#",
        free: frozenset[int] = frozenset(),
        last: int = 999_999,
    ) -> None:
        """free: numbers of the controller's own that a program may set nevertheless. last: highest number."""
        self.system, self.letter, self.free, self.last = system, letter, free, last
        self.locals_to, self.empty_locals, self.system_from = locals_to, empty_locals, system_from
        self.common: dict[Key, float | None] = {0: None} if empty_locals else {}
        for name, value in preset.items():
            key = name.upper().lstrip(letter + "#").strip("<>")
            self.common[int(key) if key.isdecimal() else key] = value
        self.local: dict[Key, float | None] = {}
        """Of the call at hand."""
        self.increment: Callable[[str], float] = lambda letter: 1.0
        """Least increment of a word by its letter, in the unit it is written in."""
        self.say: Callable[[str], None] = lambda sentence: None
        """Notes what an expression takes for granted."""

    def text(self, key: Key) -> str:
        """A variable as it is written."""
        return f"{self.letter}{key}" if isinstance(key, int) else f"#<{key.lower()}>"

    def _place(self, key: Key) -> dict[Key, float | None]:
        if isinstance(key, int):
            return self.local if 0 < key <= self.locals_to else self.common
        return self.common if key.startswith("_") else self.local

    def get(self, key: Key) -> float | None:
        """The value. Raises UnsetError."""
        if isinstance(key, int) and key > self.last:
            raise BlockError(f"{self.text(key)} is beyond the last variable, {self.text(self.last)}: choose another")
        place = self._place(key)
        if key in place:
            return place[key]
        if place is self.local and isinstance(key, int) and self.empty_locals:
            return None
        if key in self.common:
            return self.common[key]
        value = self.system(key)
        if value is None:
            raise UnsetError(self.text(key))
        return value

    def known(self, key: Key) -> bool:
        """Whether there is a value."""
        try:
            return self.get(key) is not None
        except UnsetError:
            return False

    def exists(self, key: Key) -> bool:
        """Whether there is such a variable: a number always, a name where it has a value."""
        return 0 < key <= self.last if isinstance(key, int) else self.known(key)

    def is_system(self, key: Key) -> bool:
        """Whether it is the controller's own, and not to be set."""
        if isinstance(key, str):
            return key.startswith("_") and self.system(key) is not None
        return self.system_from <= key < 10_000 and key not in self.free

    def set(self, key: Key, value: float | None) -> None:
        """Give it a value. Raises BlockError."""
        if isinstance(key, int) and not 0 < key <= self.last:
            raise BlockError(f"{self.text(key)} cannot be set: choose another variable")
        self._place(key)[key] = None if value is None else bounded(value)
