"""What the command `time` found of one program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from toolpace.operations import OperationTime
    from toolpace.timing.program_time import ProgramTime


@dataclass(frozen=True)
class Timed:
    """What was found of one program."""

    program: str
    error: str = ""
    control: str = ""
    """Empty for cutter-location data and tables, which are for none."""
    model: str = ""
    blocks: int = 0
    time: ProgramTime | None = None
    best: tuple[OperationTime, ...] = ()
    """The parts of the optimum."""
    optimum: float | None = None
    """[s], with the tool changes; None where it was not asked for."""
    assumed: tuple[str, ...] = ()
