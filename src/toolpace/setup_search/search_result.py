"""The result of a search: the best set-ups, the present one, and the gain."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec

from toolpace.common.units import format_time
from toolpace.common.value_objects import one_line
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.setup_file import setup_in, setup_text
from toolpace.programs.toolpath import ToolPath
from toolpace.setup_search.place_map import PlaceMap
from toolpace.setup_search.verified_set_up import PlannedSetUp


@dataclass(frozen=True, eq=False, repr=False)
class FoundSetUp:
    """The best set-ups for a program on a machine, each planned in full within all travels."""

    toolpath: ToolPath
    """The program as it was read on the machine as it was given."""
    best: tuple[PlannedSetUp, ...]
    """First the simplest of those as fast as the fastest, to 0.1 percent; then fastest first; the given one last."""
    given: PlannedSetUp | None
    """The set-up as it was given; None where the program cannot be run with it."""
    why: str
    """Why it cannot; empty where it can."""
    places: PlaceMap | None
    """The time over x and y, all else as in the best; None where these are not to be chosen, or it was not wanted."""
    trials: int
    """Clampings that were tried by a cheap plan."""
    seed: int
    seconds: float
    """That the search took."""

    @property
    def gain(self) -> float:
        """Share of the given duration that the best set-up saves; nan where the given one cannot be run."""
        return 1.0 - self.best[0].duration / self.given.duration if self.given is not None else float("nan")

    @property
    def machine(self) -> Machine:
        """The machine with the best set-up, ready to plan on; its set-up sheet says where the part is."""
        return with_sheet(self.best[0].machine)

    def sheet(self, setup: SetUp | None = None) -> SetUp:
        """The set-up sheet of the best set-up; `setup` is that of the given one, by default the machine file's."""
        return sheet_of(self.best[0].machine, setup)

    def changes(self) -> Mapping[str, tuple[float, float]]:
        """What limits before and after: share of the time in which each limit binds, most changed first."""
        before = self.given.limited_by if self.given is not None else {}
        after = self.best[0].limited_by
        names = sorted({*before, *after}, key=lambda name: -max(before.get(name, 0.0), after.get(name, 0.0)))
        return {name: (before.get(name, 0.0), after.get(name, 0.0)) for name in names}

    def __repr__(self) -> str:
        gain = f"gain {100.0 * self.gain:.3g} %" if self.given is not None else "as given it cannot be run"
        return one_line(
            self, f"{self.best[0].clamping.words(self.best[0].machine)}", format_time(self.best[0].duration), gain
        )


def sheet_of(machine: Machine, setup: SetUp | None = None) -> SetUp:
    """The set-up sheet of a machine with its part: that of the machine file, or `setup`, with the part where it is.

    Work offsets are left out: they tell where the part was.
    """
    given = setup_in(machine) if setup is None else setup
    chain = machine.file.chain
    part = {"origin": chain.workpiece_origin, "x": chain.workpiece_x, "z": chain.workpiece_z}
    return replace(given, part=part, offsets={})


def with_sheet(machine: Machine, setup: SetUp | None = None) -> Machine:
    """The machine with the set-up sheet of its part in its file."""
    table = tomllib.loads(setup_text(sheet_of(machine, setup)))
    return replace(machine, file=msgspec.structs.replace(machine.file, setup=table))
