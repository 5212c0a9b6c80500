"""The words of a dialect: those that its controller's file names, and those that stand in the code that reads it."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import toolpace.programs.reading
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.languages import READERS

READING = Path(next(iter(toolpace.programs.reading.__path__)))
_WORD = re.compile(r"[A-Za-z$#_<\[][\w.$#<>\[\] /+-]{0,23}")


def words_of(controller: str | None, folders: tuple[str, ...]) -> list[bytes]:
    """All words, in order; `folders` are those of `toolpace.programs.reading` whose code is looked through."""
    found: set[str] = set()
    if controller is not None:
        by = Controller.load(controller)
        found |= {*by.meanings, *by.ignored, *by.refused}
        folders = (*folders, READERS[by.language][0].split(".")[3])
    for folder in folders:
        place = READING / folder
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            found |= _strings(file)
    return [word.encode() for word in sorted(found)]


def _strings(file: Path) -> set[str]:
    """Short strings in a module that may be words of programs."""
    constants = (node.value for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Constant))
    return {text for text in constants if isinstance(text, str) and _WORD.fullmatch(text)}
