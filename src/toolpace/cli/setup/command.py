"""The checked arguments of the command `setup`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from toolpace.cli import options
from toolpace.cli.where import HERE, Where
from toolpace.common.errors import UsageError

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.setup_search.choices import Choices

MAPPED = 9
"""Places of the map along x, and along y."""


@Parameter(name="*")
@dataclass(frozen=True)
class SearchOptions:
    """Among what is searched, and how long."""

    machines: Annotated[
        str | None,
        Parameter(
            help="Several machines, separated by commas: each is searched, and the fastest is taken."
        ),
    ] = None
    choices: Annotated[
        str | None,
        Parameter(
            help="File of choices (.toml): fixture tilts, turns, places, tool lengths, and zones where the machine must"
            " not be."
        ),
    ] = None
    trials: Annotated[int, Parameter(help="How many clampings are tried on each machine, each by a cheap plan.")] = 200
    shown: Annotated[int, Parameter(help="How many of the best are planned in full, and shown.")] = 10
    seed: Annotated[int, Parameter(help="Seed of the search; another one searches in another order.")] = 0
    no_map: Annotated[bool, options.Switch, Parameter(help="Leave the map of the time over x and y out.")] = False

    def machines_named(self, machine: str | None, tool_length: str | None) -> list[tuple[str, Machine]]:
        """The machines to search, by name; `machine` where there is but one. Raises UsageError."""
        from toolpace.cli import arguments

        if machine is not None and self.machines is not None:
            raise UsageError("--machine and --machines: give one of both; the first of several is the program's own")
        names = [name.strip() for name in self.machines.split(",")] if self.machines is not None else [machine]
        if len(set(names)) < len(names):
            raise UsageError(f"--machines {self.machines}: one machine is named twice; name each once")
        return [(str(name), arguments.machine_named(name, tool_length)) for name in names]

    def choices_in(self) -> Choices:
        """The choices in the file; the usual ones where none is named."""
        from toolpace.setup_search.choices import Choices
        from toolpace.setup_search.choices_file import load_choices

        return Choices() if self.choices is None else load_choices(self.choices)


USUAL = SearchOptions()
Out = Annotated[
    str | None,
    Parameter(name=["--out", "-o"], help="Folder for the results; by default PROGRAM-setup in the current folder."),
]


def setup_command(
    program: options.Program,
    /,
    *,
    machine: options.MachineName = None,
    search: SearchOptions = USUAL,
    tolerances: options.Tolerances = options.USUAL_TOLERANCES,
    feed: options.Feed = None,
    tool_length: options.ToolLength = None,
    dialect: options.Dialect = None,
    out: Out = None,
    where: Where = HERE,
    reading: options.Reading = options.AS_WRITTEN,
) -> int:
    """Find where to clamp the part, with which fixture and tool, so that a program is fastest within all travels.

    Clampings are tried by cheap plans; the best ten are planned in full. The
    program is read for the machine as it is (of several, the first), and written
    out as tips and tool axes, which hold for any clamping. Collisions are not
    checked: the file of --choices lists the choices, and the zones where the
    machine must not be. docs: where to clamp the part.

    For example:

        toolpace setup part.ngc -m xyzac-trunnion
        toolpace setup part.ngc -m my-mill.toml --choices fixtures.toml --out part-setup
        toolpace setup part.cls --machines xyzac-trunnion,xyzbc-head,my-mill.toml
    """
    from toolpace.cli import arguments
    from toolpace.cli.setup.run import AskedSearch, run_setup

    named = search.machines_named(machine, tool_length)
    first, how = arguments.machine_with_setup(named[0][1], reading)
    return run_setup(
        AskedSearch(
            program=program,
            machines=((named[0][0], first), *named[1:]),
            choices=search.choices_in(),
            tolerances=arguments.even_tolerances(tolerances),
            trials=search.trials,
            seed=search.seed,
            shown=search.shown,
            mapped=0 if search.no_map else MAPPED,
            client=where.client(),
            out=arguments.folder_for_results(arguments.default_folder(program, "setup") if out is None else out),
            feed=arguments.feed_asked(feed),
            dialect=dialect,
            options=how,
        )
    )
