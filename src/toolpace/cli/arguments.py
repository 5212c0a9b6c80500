"""Arguments as people type them: checked before any work begins, and explained when they are wrong."""

from __future__ import annotations

import difflib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from toolpace import units
from toolpace.errors import UsageError
from toolpace.planning.planner import PLANNERS

if TYPE_CHECKING:
    from cyclopts import CycloptsError

    from toolpace.machine.machine import Machine


def planner_named(name: str) -> str:
    """The planner, or an error that names the nearest."""
    if name in PLANNERS:
        return name
    near = difflib.get_close_matches(name.lower(), PLANNERS, n=1, cutoff=0.4)
    hint = f"did you mean '{near[0]}'? " if near else ""
    raise UsageError(f"unknown planner '{name}'; {hint}known are {', '.join(PLANNERS)}")


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


def tolerances(tip: str, axis: str) -> tuple[float, float]:
    """Both tolerances [m], [rad], above zero."""
    metres, radians = units.parse_length(tip), units.parse_angle(axis)
    if not metres > 0.0:
        raise UsageError(f"--tip-tolerance {tip}: a curve needs room to be smooth; give more than zero, like 0.001mm")
    if not radians > 0.0:
        raise UsageError(f"--axis-tolerance {axis}: a curve needs room to be smooth; give more than zero, like 0.01deg")
    return metres, radians


def time_to_prove(text: str, planner: str) -> float:
    """The time for the proof [s] of a plan that can have one."""
    if planner != "optimal":
        raise UsageError(f"--prove goes with the planner 'optimal'; the planner '{planner}' has no lower bound")
    return units.parse_time(text)


def feed_asked(feed: str | None) -> str | None:
    """The text of --feed, found to be one."""
    if feed is not None:
        from toolpace.reading.feeds import FeedChange

        FeedChange.parse(feed)
    return feed


def folder_to_write(out: str) -> Path:
    """The folder for the results, found writable before work that may take minutes."""
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"--out {out}: is a file; give a folder to write into")
    above = folder
    while not above.exists() and above != above.parent:
        above = above.parent
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise UsageError(f"--out {out}: cannot write into {above}; give another folder")
    return folder


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
        given = argument in tokens
        name = argument if given or argument not in ("--program", "--directory") else argument[2:].upper()
        text = f"{name} needs a value" if given else f"{name} is missing"
    return f"{text}; {cure}"
