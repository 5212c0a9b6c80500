"""Tells by its content which controller a program was written for."""

from __future__ import annotations

import re
from functools import cache
from pathlib import PurePath

from toolpace.reading.controllers.controller import Controller
from toolpace.reading.source import Source

FALLBACK = "iso"
LINES, LENGTH = 20_000, 300
"""How many lines are looked at, and how much of each: signs stand early, or often."""
SUFFIX_WEIGHT = 1.0
"""Of the ending of the name: less than most signs."""
_COMMENT = re.compile(r"\([^()]*\)")


@cache
def built_in() -> tuple[Controller, ...]:
    """All of them; those that are like another behind the others, since they have its signs too."""
    return tuple(sorted(map(Controller.load, Controller.names()), key=lambda controller: controller.like != ""))


def recognise(source: Source, controllers: tuple[Controller, ...] | None = None) -> tuple[Controller, str]:
    """The controller whose signs weigh most, and why; each sign counts once. Time is linear in the program."""
    controllers = built_in() if controllers is None else controllers
    said = "\n".join(line[:LENGTH] for line in source.lines[:LINES]).upper()
    text = _COMMENT.sub("", said)
    suffix = PurePath(source.name).suffix.lower()
    best: tuple[float, Controller | None, str] = (0.0, None, "")
    for controller in controllers:
        found = [
            (sign.weight, sign.reason)
            for sign in controller.signs
            if re.search(sign.pattern, said if sign.comments else text, re.MULTILINE)
        ]
        weight = sum(part for part, _ in found)
        if suffix and suffix in controller.suffixes:
            weight += SUFFIX_WEIGHT
            found.append((SUFFIX_WEIGHT, f"names that end with {suffix} are of {controller.name}"))
        if weight > best[0]:
            best = (weight, controller, max(found)[1])
    _, chosen, reason = best
    if chosen is None:
        return Controller.load(FALLBACK), "nothing in the program tells its controller"
    return chosen, reason
