"""Checked options of planners, with one-line errors."""

from __future__ import annotations

import inspect
from typing import ClassVar, Self

import numpy as np

from toolpace.common.errors import UsageError, did_you_mean

FEWEST_CELLS = 8
"""Fewer have no cell between those next to the ends."""


class OptionsSignature:
    """The options of a planner, for those who ask its class: help(), and completion in a running session."""

    def __get__(self, planner: Options | None, kind: type[Options]) -> inspect.Signature:
        options = list(inspect.signature(kind.__init__).parameters.values())[1:]
        return inspect.Signature(options)


class Options:
    """Base of the planners, which are frozen dataclasses: an unknown option is a UsageError that names the nearest."""

    __match_args__: ClassVar[tuple[str, ...]] = ()
    __signature__: ClassVar[OptionsSignature] = OptionsSignature()

    def __new__(cls, *values: object, **options: object) -> Self:
        names = cls.__match_args__
        for name in options:
            if name not in names:
                raise UsageError(f"{cls.__name__}: no option '{name}'; {did_you_mean(name, names)}")
        if len(values) > len(names) or any(name in options for name in names[: len(values)]):
            raise UsageError(f"{cls.__name__}: more options than there are; give them by name: {', '.join(names)}")
        return super().__new__(cls)


def check_whole(planner: str, name: str, value: object, low: int, high: int) -> None:
    """Raise UsageError where an option is no whole number from low to high."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or not low <= value <= high:
        raise UsageError(f"{planner}: {name} is {value!r}; it must be a whole number in [{low}, {high}]")


def check_share(planner: str, name: str, value: object, low: float, high: float) -> None:
    """Raise UsageError where an option is no number from low to high."""
    if not isinstance(value, int | float | np.number) or isinstance(value, bool) or not low <= value <= high:
        raise UsageError(f"{planner}: {name} is {value!r}; it must be a number in [{low:g}, {high:g}]")


def check_flag(planner: str, name: str, value: object) -> None:
    """Raise UsageError where an option is neither True nor False."""
    if not isinstance(value, bool):
        raise UsageError(f"{planner}: {name} is {value!r}; give True or False")


def check_mesh(planner: str, mesh: object) -> None:
    """Raise UsageError where a number of mesh cells is none, or too small."""
    if mesh is None:
        return
    if not isinstance(mesh, int | np.integer) or isinstance(mesh, bool):
        raise UsageError(f"{planner}: mesh is {mesh!r}; give a whole number of cells, or None")
    if mesh < FEWEST_CELLS:
        raise UsageError(f"{planner}: a mesh of {mesh} cells is too coarse; give at least {FEWEST_CELLS}")
