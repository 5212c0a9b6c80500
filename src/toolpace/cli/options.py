"""The options of the commands: names, types, help."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from toolpace.common.errors import UsageError

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import ReadOptions

Switch = Parameter(negative="", show_default=False)
"""An option that is there or not."""

Program = Annotated[
    str, Parameter(help="G-code, APT, CLSF or a table (CSV) of points and tool axes; - is standard input.")
]
MachineName = Annotated[
    str | None,
    Parameter(
        name=["--machine", "-m"],
        help="Name of a built-in machine (see `toolpace machines`) or a machine file (.toml). Required.",
    ),
]
TIP_TOLERANCE, AXIS_TOLERANCE = "0.01mm", "0.05deg"
"""Where no others are given."""
TipTolerance = Annotated[
    str,
    Parameter(
        help="Tolerance of the tip: how far a smooth path may be from the program: 0.01mm, 5um, 0.0004in. By operation,"
        " tool or blocks: 20um,finish:5um,T2:8um,N100-N250:5um. As the program asks: program,10um; where it asks for"
        " less: tighter,10um."
    ),
]
AxisTolerance = Annotated[
    str,
    Parameter(
        help="Tolerance of the tool axis: how far it may turn from the program's: 0.05deg, 1e-3rad,"
        " 0.2deg,finish:0.05deg."
    ),
]

Side = Annotated[
    str,
    Parameter(
        help="Side on which the tip may be off the program. both: on both. outside: only out of the part, by the"
        " normals in the program (NX NY NZ of LN). above: only towards the spindle, along the tool axis."
    ),
]


@Parameter(name="*")
@dataclass(frozen=True)
class Tolerances:
    """How far the tool may be from the program."""

    tip_tolerance: TipTolerance = TIP_TOLERANCE
    axis_tolerance: AxisTolerance = AXIS_TOLERANCE
    side: Side = "both"


USUAL_TOLERANCES = Tolerances()
TIGHTER_TOLERANCES = Tolerances(f"tighter,{TIP_TOLERANCE}", f"tighter,{AXIS_TOLERANCE}")
"""The usual ones, or what the program asks for where that is less."""
TOLERANCES_OF_PROGRAM = Tolerances(f"program,{TIP_TOLERANCE}", f"program,{AXIS_TOLERANCE}")
"""What the program asks for itself; where it asks for none, the usual ones."""
Effort = Annotated[
    str,
    Parameter(
        help="How much the path is optimised. low: the smoothest path, fitted once. normal: a few iterations of path"
        " and speed; for a short program also a quick optimisation of both together. high: a thorough one."
    ),
]
PlannerName = Annotated[
    str,
    Parameter(
        help="optimal: least time. genetic: the method of Wu, Li, Liu and Perez (ACC 2009). second-order: least time"
        " without jerk limits, for comparison; it fails the verification of jerk."
    ),
]
Prove = Annotated[
    bool,
    Switch,
    Parameter(
        help="After planning, raise the lower bound of the time until the gap is 0.01 %, or --prove-within is over:"
        " this proves how close the plan is to the fastest possible one."
    ),
]
ProveWithin = Annotated[str, Parameter(help="Most time that --prove takes.")]
Prices = Annotated[
    bool,
    Switch,
    Parameter(help="Show what more of each limit of the machine would save, for this program on its path."),
]
Feed = Annotated[
    str | None,
    Parameter(
        help="Feed in place of the program's: a factor (120%), a value (3000mm/min), or none: as fast as the machine"
        " can."
    ),
]
TimeStep = Annotated[str, Parameter(help="Time between set-points.")]
Out = Annotated[
    str | None,
    Parameter(name=["--out", "-o"], help="Folder for the results; by default PROGRAM-plan in the current folder."),
]
Csv = Annotated[bool, Switch, Parameter(help="Also write the set-points as a table (setpoints.csv).")]
ToolLength = Annotated[
    str | None, Parameter(help="Length from the spindle nose to the tip, in place of the machine file's: 120mm.")
]
Dialect = Annotated[
    str | None, Parameter(help="Format of the program, where its name does not show it: gcode, apt or csv.")
]
Npz = Annotated[
    str,
    Parameter(
        help="How set-points are written. full: setpoints.npz, arrays of numpy. compact: setpoints.compact, a thirtieth"
        " of it, read by toolpace alone. auto: full up to 20 MB, else compact. no: not at all, where only the time of a"
        " long program is wanted; the plan can then be neither verified again nor exported."
    ),
]
Bend = Annotated[
    str | None,
    Parameter(
        help="Tool file (.toml: stiffness, cutting coefficients, engagement; docs: bending). The path is compensated"
        " for the bending of the tool under its cutting forces, so that the bent tip is where the program says."
    ),
]
NoReport = Annotated[bool, Switch, Parameter(help="Leave report.html out.")]


@Parameter(name="*")
@dataclass(frozen=True)
class Files:
    """What is written beside plan.json, and in which steps of time."""

    dt: TimeStep = "1ms"
    csv: Csv = False
    npz: Npz = "auto"
    no_report: NoReport = False


@Parameter(name="*")
@dataclass(frozen=True)
class Reading:
    """How a program is to be read."""

    controller: Annotated[
        str | None,
        Parameter(
            help="Controller that the program is for: a name (see `toolpace controllers`) or a file (.toml). By default"
            " it is recognised from the program."
        ),
    ] = None
    setup: Annotated[
        str | None,
        Parameter(
            help="Set-up sheet (.toml): work offsets, reference points, tools, where the part is clamped."
            " `toolpace inspect --write-setup` writes one to fill in."
        ),
    ] = None
    skip_unknown: Annotated[
        bool, Switch, Parameter(help="Skip words that are not read, with a note, instead of refusing them.")
    ] = False
    lenient: Annotated[
        bool,
        Switch,
        Parameter(
            help="Read on, with a note, where the control would stop and the meaning is certain (no M2 at the end,"
            " a word twice)."
        ),
    ] = False
    compensation: Annotated[
        str | None,
        Parameter(help="program: under G41, G42, RL and RR the tool's centre follows the programmed contour."),
    ] = None
    max_blocks: Annotated[
        int | None,
        Parameter(
            help="Most blocks that may be executed; a program with more is refused as an endless loop. By default this"
            " follows from its length."
        ),
    ] = None

    columns: Annotated[
        str,
        Parameter(
            help="Columns of a table without a header, or in place of it: x,y,z,i,j,k; feed, rapid, stop, dwell too.",
            show_default=False,
        ),
    ] = ""
    units: Annotated[
        str,
        Parameter(
            help="Unit of a table whose header names none: mm, m, in. Feeds are in it per minute, dwells in s.",
            show_default=False,
        ),
    ] = ""

    def options(self, machine: Machine | None) -> ReadOptions:
        """The options, with files loaded. Raises UsageError."""
        from toolpace.programs.reading import ReadOptions

        return ReadOptions.of(
            machine,
            self.controller,
            self.setup,
            self.skip_unknown,
            True,
            self.compensation or "",
            self.max_blocks,
            self.lenient,
            self.columns,
            self.units,
        )


USUAL_FILES = Files()
AS_WRITTEN = Reading()
"""Nothing but the program tells."""
PlanFolder = Annotated[str, Parameter(help="The folder that `toolpace plan` wrote.")]
OneMachine = Annotated[
    str | None, Parameter(help="Machine, or machine file, to show; by default all built-in machines.")
]
Toml = Annotated[
    bool, Switch, Parameter(help="Print the machine file, with a comment on each line.")
]
Poses = Annotated[
    bool,
    Switch,
    Parameter(
        help="Print poses to compare with the real machine: joints, and tip and tool axis in the frame of the part."
    ),
]
Results = Annotated[str, Parameter(name=["--out", "-o"], help="Folder for the results.")]

Programs = Annotated[
    list[str], Parameter(help="Programs: G-code of any controller, APT, CLSF, CSV; - is standard input.")
]
MachineToInspect = Annotated[
    str | None,
    Parameter(name=["--machine", "-m"], help="Machine to read the program for; by default each built-in machine."),
]
Json = Annotated[
    bool, Switch, Parameter(name="--json", help="Print the findings as JSON: a list with one entry for each file.")
]
WriteSetup = Annotated[
    str | None,
    Parameter(help="Write a set-up sheet to fill in to this file: the offsets, references and tools that are used."),
]
OneController = Annotated[str | None, Parameter(help="Controller to show; by default all built-in ones.")]
ControllerToml = Annotated[bool, Switch, Parameter(name="--toml", help="Print the controller's file.")]
ControlModel = Annotated[
    str | None,
    Parameter(
        help="Model of the control, in place of the one in its file: linuxcnc, sinumerik, heidenhain, fanuc,"
        " lookahead, or ideal (the optimum itself)."
    ),
]
NoOptimum = Annotated[bool, Switch, Parameter(help="Leave the optimum out; then programs are not planned.")]
FitLog = Annotated[
    str | None,
    Parameter(
        name="--fit",
        help="Find the figures of the control from what was measured while it ran the program: a log (CSV) of the axis"
        " positions with columns t [s] and joints [mm, deg]; a list (text, CSV) of operations and their times; or one"
        " time, like 3:12.",
    ),
]
WriteController = Annotated[
    str | None, Parameter(help="With --fit: write the controller's file with these figures; by default it is printed.")
]


@Parameter(name="*")
@dataclass(frozen=True)
class Where:
    """Where work of many parts runs: on a cluster, or in processes of this computer."""

    cluster: Annotated[
        str | None,
        Parameter(
            help="Address of a dask scheduler, like tcp://10.0.0.5:8786; by default workers are started on this"
            " computer."
        ),
    ] = None
    workers: Annotated[
        int | None,
        Parameter(help="Workers to start on this computer; by default one for each core; 0: this process alone."),
    ] = None

    def client(self) -> str | int | None:
        """The one that was given, as `open_pool` takes it. Raises UsageError."""
        if self.cluster is not None and self.workers is not None:
            raise UsageError("--cluster and --workers: one of them; a cluster has the workers that it has")
        if self.workers is not None and self.workers < 0:
            raise UsageError(f"--workers {self.workers}: give 1 or more, or 0 for this process")
        return self.cluster if self.cluster is not None else self.workers


HERE = Where()
