"""Options of reading beside the program's text."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from toolpace.common.errors import UsageError, did_you_mean
from toolpace.programs.reading.controllers.controller import Controller
from toolpace.programs.reading.coordinates.kinematics import Kinematics
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.setup_file import check_setup, load_setup, setup_in

PROGRAM = "program"
"""What `compensation` may be."""


@dataclass(frozen=True)
class ReadOptions:
    """What a user may choose."""

    controller: Controller | None = None
    """The control that the program is for; None: found from its content."""
    others: tuple[Controller, ...] = ()
    """Where `controller` was found: controls that the program may be for as well. What they would read otherwise is
    said in `ToolPath.assumed`."""
    setup: SetUp = field(default_factory=SetUp)
    skip_unknown: bool = False
    """Whether words that are not read are passed over, and said, in place of being refused."""
    lenient: bool = False
    """Whether what is read is said only, in place of being refused, where the control itself would stop at it."""
    block_delete: bool = True
    """Whether blocks that begin with `/` are passed over."""
    compensation: str = ""
    """"program": under G41, G42, RL and RR the centre follows the programmed contour; "": beside it, by the radius."""
    most_blocks: int | None = None
    """Blocks that are executed: more is taken for a loop without end; None: as the length of the program explains."""
    columns: str = ""
    """Names of the columns of a table whose header does not tell them: "x,y,z,i,j,k"."""
    units: str = ""
    """Unit of its lengths, where its header names none: "mm"; feeds are in it per minute, dwells in seconds."""
    default_feed: float | None = None
    """Speed of motions for which the program gives no F [m/s]; None makes that an error."""

    @staticmethod
    def of(
        machine: Kinematics | None = None,
        controller: str | Path | Controller | None = None,
        setup: str | Path | SetUp | None = None,
        skip_unknown: bool = False,
        block_delete: bool = True,
        compensation: str = "",
        max_blocks: int | None = None,
        lenient: bool = False,
        columns: str = "",
        units: str = "",
    ) -> ReadOptions:
        """Options as people give them: names and files are loaded. Raises UsageError."""
        if machine is not None and not callable(getattr(machine, "rotary_solutions", None)):
            shown = f"'{machine}'" if isinstance(machine, str) else type(machine).__name__
            raise UsageError(f"read: machine is {shown}; give a Machine, such as Machine.load('xyzac-trunnion')")
        if isinstance(controller, (str, Path)):
            controller = Controller.load(controller)
        if controller is not None and not isinstance(controller, Controller):
            raise UsageError(f"read: {type(controller).__name__} in place of a controller; give its name, or a file")
        if setup is None:
            setup = setup_in(machine)
        elif isinstance(setup, (str, Path)):
            setup = load_setup(setup)
        elif not isinstance(setup, SetUp):
            raise UsageError(f"read: {type(setup).__name__} in place of a set-up sheet; give a SetUp, or a file")
        for name, switch in (("skip_unknown", skip_unknown), ("block_delete", block_delete), ("lenient", lenient)):
            if not isinstance(switch, bool):
                raise UsageError(f"read: {name} is {str(switch)[:40]!r}; give True or False")
        if compensation not in ("", PROGRAM):
            raise UsageError(
                f"--compensation '{compensation[:40]}' is not known; {did_you_mean(compensation, [PROGRAM])}"
            )
        if max_blocks is not None and not (isinstance(max_blocks, int) and max_blocks >= 1):
            raise UsageError(f"--max-blocks {max_blocks}: give the most blocks that may be executed, 1 or more")
        return ReadOptions(
            controller,
            setup=setup,
            skip_unknown=skip_unknown,
            lenient=lenient,
            block_delete=block_delete,
            compensation=compensation,
            most_blocks=max_blocks,
            columns=columns,
            units=units,
        )

    def check(self, machine: Kinematics | None) -> None:
        """Raise UsageError where the set-up sheet does not fit the machine."""
        if machine is not None:
            check_setup(self.setup, machine)
