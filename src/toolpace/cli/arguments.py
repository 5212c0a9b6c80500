"""Checks of command-line arguments, with explanations."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace.common import units
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.files import file_to_write, folder_to_write
from toolpace.jobs.job import AXIS_TOLERANCES, TIME_STEPS, TIP_TOLERANCES
from toolpace.planning.planner import PLANNERS
from toolpace.programs.reading.source import STANDARD_INPUT

if TYPE_CHECKING:
    from cyclopts import CycloptsError

    from toolpace.cli.options import Reading
    from toolpace.cli.options import Tolerances as TypedTolerances
    from toolpace.machine.cutting_tool import CuttingTool
    from toolpace.machine.machine import Machine
    from toolpace.programs.reading import ReadOptions
    from toolpace.programs.tolerances import Tolerances

NEGATIVE = re.compile(r"-[0-9.]")
"""How a negative number begins, that was taken for an option."""


def planner_named(name: str) -> str:
    """The planner, or an error that names the nearest."""
    if name in PLANNERS:
        return name
    near = difflib.get_close_matches(name.lower(), PLANNERS, n=1, cutoff=0.4)
    hint = f"did you mean '{near[0]}'? " if near else ""
    raise UsageError(f"unknown planner '{name[:40]}'; {hint}known are {', '.join(PLANNERS)}")


def effort_named(name: str) -> str:
    """The effort, or an error that names the nearest."""
    from toolpace.planning.program_plan import EFFORTS

    if name in EFFORTS:
        return name
    raise UsageError(f"--effort '{name[:40]}' is not known; {did_you_mean(name, EFFORTS)}")


def machine_named(name: str | None, tool_length: str | None = None) -> Machine:
    """The machine, with another tool where its length is given."""
    from toolpace.machine.machine import Machine

    if name is None:
        raise UsageError(
            f"--machine is missing: name a built-in machine ({', '.join(Machine.names())}) or a machine file (.toml); "
            "`toolpace machines` describes them"
        )
    machine = Machine.load(name)
    return machine if tool_length is None else machine.with_tool(units.parse_length(tool_length))


def machine_with_setup(machine: Machine, reading: Reading) -> tuple[Machine, ReadOptions]:
    """The machine with the part clamped as the set-up sheet says, and how to read for it."""
    how = reading.options(machine)
    return (machine.mounted(**how.setup.part) if how.setup.part else machine), how


def one_machine(name: str | None, toml: bool, poses: bool) -> str:
    """The machine whose file (`toml`) or whose poses are to be printed: one machine, and one of both."""
    if toml and poses:
        raise UsageError("--toml and --poses: one at a time, so that what is printed by --toml is a machine file")
    if name is None:
        option = "--toml" if toml else "--poses"
        raise UsageError(f"{option} needs the name of one machine: toolpace machines xyzac-trunnion {option}")
    return name


def tolerances(typed: TypedTolerances) -> tuple[float | Tolerances, float | Tolerances]:
    """Both tolerances [m], [rad], above zero: numbers, or by operation, tool and blocks."""
    from toolpace.cli.options import AXIS_TOLERANCE, TIGHTER_TOLERANCES, TIP_TOLERANCE, TOLERANCES_OF_PROGRAM
    from toolpace.programs.tolerances import SIDES, Tolerances

    metres = _above_zero("--tip-tolerance", units.parse_length, TIP_TOLERANCES, units.format_length, "0.001mm")
    radians = _above_zero("--axis-tolerance", units.parse_angle, AXIS_TOLERANCES, units.format_angle, "0.01deg")
    words = typed.tip_tolerance
    if typed.side != "both":
        # a side goes with one tolerance for all
        untyped = words in (TOLERANCES_OF_PROGRAM.tip_tolerance, TIGHTER_TOLERANCES.tip_tolerance)
        words = f"{TIP_TOLERANCE if untyped else words},{typed.side}"
    if typed.side not in SIDES:
        raise UsageError(f"--side {typed.side[:40]}: {did_you_mean(typed.side, SIDES)}")
    of_tip = Tolerances.parse(words, metres, metres(TIP_TOLERANCE))
    of_axis = Tolerances.parse(typed.axis_tolerance, radians, radians(AXIS_TOLERANCE))
    return of_tip.default if of_tip.everywhere else of_tip, of_axis.default if of_axis.everywhere else of_axis


def _above_zero(
    option: str,
    parse: Callable[[str], float],
    bounds: tuple[float, float],
    show: Callable[[float], str],
    example: str,
) -> Callable[[str], float]:
    """Reads the tolerances of an option, which must be within bounds."""

    def tolerance(text: str) -> float:
        value = _parsed(option, parse, text)
        if not value > 0.0:
            raise UsageError(f"{option} {text}: a curve needs room to be smooth; give more than zero, like {example}")
        return _within(option, text, value, bounds, show)

    return tolerance


def _parsed(option: str, quantity: Callable[[str], float], text: str) -> float:
    """A quantity of an option, which an error names."""
    try:
        return quantity(text)
    except UsageError as error:
        raise UsageError(f"{option}: {error}") from None


def even_tolerances(typed: TypedTolerances) -> tuple[float, float]:
    """Both tolerances [m], [rad], each the same everywhere. Raises UsageError."""
    tip, axis = tolerances(typed)
    options = ("--tip-tolerance", typed.tip_tolerance, tip), ("--axis-tolerance", typed.axis_tolerance, axis)
    for option, text, found in options:
        if not isinstance(found, float):
            raise UsageError(
                f"{option} {text[:40]}: one for all here, on both sides; by operation or block, or on one side, it goes"
                " with `plan`"
            )
    assert isinstance(tip, float) and isinstance(axis, float)
    return tip, axis


def tip_tolerances(text: str) -> list[float]:
    """Tolerances of the tip [m], between commas."""
    found = []
    for part in text.split(","):
        metres = _parsed("--tips", units.parse_length, part.strip())
        found.append(_within("--tips", part.strip(), metres, TIP_TOLERANCES, units.format_length))
    return found


def time_step(text: str) -> float:
    """The time between set-points [s]."""
    return _within("--dt", text, units.parse_time(text), TIME_STEPS, units.format_time)


def tool_named(path: str | None) -> CuttingTool | None:
    """The tool that bends, from its file; None where none is given."""
    if path is None:
        return None
    from toolpace.cutting.tool_file import load_tool

    return load_tool(path)


def form_of_set_points(text: str) -> str:
    """How set-points are written: full, compact, auto or no."""
    from toolpace.motion.set_point_files import form_named

    return form_named("--npz", text)


def time_option(option: str, text: str) -> float:
    """A time [s], named by its option where it is wrong."""
    return _parsed(option, units.parse_time, text)


def _within(option: str, text: str, value: float, bounds: tuple[float, float], show: Callable[[float], str]) -> float:
    if not bounds[0] <= value <= bounds[1]:
        raise UsageError(f"{option} {text[:40]}: give a value from {show(bounds[0])} to {show(bounds[1])}")
    return value


def time_to_prove(text: str, planner: str) -> float:
    """The time for the proof [s] of a plan that can have one."""
    if planner != "optimal":
        raise UsageError(f"--prove goes with the planner 'optimal'; the planner '{planner}' has no lower bound")
    return units.parse_time(text)


def priced(prices: bool, planner: str) -> bool:
    """Whether prices are asked for, of a plan that can have them."""
    if prices and planner != "optimal":
        raise UsageError(f"--prices goes with the planner 'optimal'; the planner '{planner}' has no multipliers")
    return prices


def feed_option(feed: str | None) -> str | None:
    """The text of --feed, found to be one."""
    if feed is not None:
        from toolpace.programs.reading.feeds import FeedChange

        FeedChange.parse(feed)
    return feed


def control_model(name: str | None) -> str | None:
    """The name of a model of a control, or None. Raises UsageError."""
    from toolpace.controls.timing.figures import FORMER_MODELS, MODELS

    if name is None or name in MODELS:
        return name
    if name in FORMER_MODELS:
        raise UsageError(f"--model {name}: there is no such model any more; take {FORMER_MODELS[name]}")
    raise UsageError(f"--model '{name[:40]}' is not known; {did_you_mean(name, MODELS)}")


def folder_for_results(out: str, option: str = "--out") -> Path:
    """The folder for the results, found fit for them before work that may take minutes."""
    try:
        folder_to_write(out)
    except UsageError as error:
        raise UsageError(f"{option} {error}") from None
    return Path(out)


def file_for_result(option: str, path: str | None) -> Path | None:
    """The new file for a result, found fit for it before work that may take minutes; None where none is asked for."""
    try:
        return None if path is None else file_to_write(path)
    except UsageError as error:
        raise UsageError(f"{option} {error}") from None


def default_folder(program: str, what: str = "plan") -> str:
    """Named after the program and what it is for: part-plan; pipes and devices have names that say nothing."""
    path = Path(program)
    try:
        named = path.is_file() or not path.exists()
    except (OSError, ValueError):
        named = True
    return f"{path.stem if named and program not in STANDARD_INPUT else 'program'}-{what}"


def explain(error: CycloptsError, tokens: Sequence[str]) -> str:
    """What is wrong with the arguments, in one line."""
    from cyclopts import MissingArgumentError, UnknownCommandError, UnusedCliTokensError

    text = " ".join(str(error).split()).removesuffix(".")
    command = tokens[0] if tokens and not tokens[0].startswith("-") else ""
    cure = f"`toolpace {command} --help` explains" if command else "`toolpace --help` explains"
    if isinstance(error, UnknownCommandError):
        cure = "`toolpace --help` explains"
    if isinstance(error, UnusedCliTokensError):
        text = f"too many arguments: {' '.join(error.unused_tokens or ())}"
    elif isinstance(error, MissingArgumentError):
        argument = error.argument.name if error.argument is not None else ""
        is_named = argument in tokens
        name = argument if is_named or argument not in ("--program", "--directory") else argument[2:].upper()
        text = f"{name} needs a value" if is_named else f"{name} is missing"
        value = tokens[tokens.index(argument) + 1 :][:1] if is_named else []
        if value and NEGATIVE.match(value[0]):
            text = f"{name} {value[0]} is negative; give a value above zero, like {value[0].lstrip('-')}"
    return f"{text}; {cure}"
