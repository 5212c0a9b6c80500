"""The files of a program: its own, and those that it calls."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from toolpace.programs.reading.gcode.program.layout import Layout
from toolpace.programs.reading.source import Source


class Text:
    """A file of blocks."""

    def __init__(self, source: Source, to_tape_end: bool = False) -> None:
        self.source, self.to_tape_end = source, to_tape_end

    @cached_property
    def layout(self) -> Layout:
        """Where its labels and loops are."""
        return Layout(self.source, self.to_tape_end)


class Files:
    """Finds programs by name."""

    def __init__(self, source: Source, to_tape_end: bool = False) -> None:
        self.to_tape_end = to_tape_end
        self.main = Text(source, to_tape_end)
        self.beside: dict[str, Text | None] = {}
        """Files that were looked for; None where there is none."""

    def find(self, present: Text, name: str, sub: bool) -> tuple[Text, int] | None:
        """File and first line of a program, or of an O-word's subprogram; None where there is none."""
        for text in (present, self.main):
            found = self._in(text, name, sub)
            if found is not None:
                return found
        beside = self._beside(name)
        if beside is None:
            return None
        return self._in(beside, name, sub) or (beside, 0)

    def lines_beside(self) -> int:
        """Lines of the files that were called."""
        return sum(len(text.source.lines) for text in self.beside.values() if text is not None)

    @staticmethod
    def _in(text: Text, name: str, sub: bool) -> tuple[Text, int] | None:
        line = (text.layout.subs if sub else text.layout.programs).get(name)
        return None if line is None else (text, line + 1)

    def _beside(self, name: str) -> Text | None:
        """A file of that name in the folder of the program."""
        if name not in self.beside:
            self.beside[name] = None
            path = Path(self.main.source.name)
            safe = all(mark.isalnum() or mark in "_-." for mark in name)
            if safe and path.is_file():
                stems = [name.lower(), f"o{name.lower()}", f"o{name.lower():0>4}", f"{name.lower():0>4}"]
                wanted = {stem + suffix for stem in stems for suffix in (path.suffix.lower(), ".ngc", ".nc", "")}
                files = sorted(other for other in path.parent.iterdir() if other.name.lower() in wanted)
                found = next((other for other in files if other.is_file() and other != path), None)
                self.beside[name] = None if found is None else Text(Source.load(found), self.to_tape_end)
        return self.beside[name]
