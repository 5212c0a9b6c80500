"""The options of planners: what is misspelt or of the wrong kind is told in one line."""

from __future__ import annotations

from numbers import Integral
from typing import ClassVar, Self

from toolpace.errors import UsageError, did_you_mean

FEWEST_CELLS = 8
"""Fewer have no cell between those next to the ends."""


class Options:
    """Base of the planners, which are frozen dataclasses: an unknown option is a UsageError that names the nearest."""

    __match_args__: ClassVar[tuple[str, ...]] = ()

    def __new__(cls, *given: object, **options: object) -> Self:
        known = cls.__match_args__
        for name in options:
            if name not in known:
                raise UsageError(f"{cls.__name__}: no option '{name}'; {did_you_mean(name, known)}")
        if len(given) > len(known) or any(name in options for name in known[: len(given)]):
            raise UsageError(f"{cls.__name__}: more options than there are; give them by name: {', '.join(known)}")
        return super().__new__(cls)


def check_mesh(planner: str, mesh: object) -> None:
    """Raise UsageError where a number of mesh cells is none, or too small."""
    if mesh is None:
        return
    if not isinstance(mesh, Integral) or isinstance(mesh, bool):
        raise UsageError(f"{planner}: mesh is {mesh!r}; give a whole number of cells, or None")
    if mesh < FEWEST_CELLS:
        raise UsageError(f"{planner}: a mesh of {mesh} cells is too coarse; give at least {FEWEST_CELLS}")
