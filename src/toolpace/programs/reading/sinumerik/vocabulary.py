"""The words of a controller file: meanings, words without motion, unread words."""

from __future__ import annotations

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import INCH, MILLIMETRE
from toolpace.programs.reading.controllers.controller import Controller

IGNORED = "ignored"
UNITS = {"program": None, "mm": MILLIMETRE, "inch": INCH}


class Vocabulary:
    """Words of one controller; a name that ends in * stands for all that begin so."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self._meanings = dict(controller.meanings) | dict.fromkeys(controller.ignored, IGNORED)
        self._refused = dict(controller.refused)
        self._beginnings = tuple(name[:-1] for name in self._refused if name.endswith("*"))
        self.base_unit = UNITS[controller.option("base_unit", "program")]

    def check(self, known: tuple[str, ...]) -> None:
        """UsageError where the file gives a word a meaning that does not exist."""
        for word, meaning in self.controller.meanings.items():
            if meaning not in known:
                near = did_you_mean(meaning, known)
                raise UsageError(f"{self.controller.source}: {word} = '{meaning}' is no meaning: {near}")

    def meaning(self, word: str) -> str:
        """What a word does, "ignored", or "" where the file does not say."""
        return self._meanings.get(word, "")

    def refusal(self, word: str) -> str:
        """The cure for a word that is not read; "" where the file does not name it."""
        found = self._refused.get(word)
        if found is not None:
            return found
        for beginning in self._beginnings:
            if word.startswith(beginning):
                return self._refused[beginning + "*"]
        return ""
