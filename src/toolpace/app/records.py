"""Parts, requests and jobs of the app, the rules of feeds that a request sets, and the command that does the same."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any, Literal

import msgspec

from toolpace.common.errors import UsageError, did_you_mean, printable
from toolpace.jobs.batch import BatchRow

if TYPE_CHECKING:
    from toolpace.cutting.feeds.rules import FeedRules

CUT_FEEDS = ("air", "learned", "limits")
"""Feeds that follow from the cut; others are those of the option --feed."""
State = Literal["waiting", "ended", "stopped"]


class Reading(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a program is read: options of the commands, as text; empty: not given."""

    controller: str = ""
    dialect: str = ""
    skip_unknown: bool = False
    lenient: bool = False
    compensation: str = ""
    columns: str = ""
    units: str = ""
    max_blocks: int | None = None


class Part(msgspec.Struct, frozen=True, kw_only=True):
    """A program with the files that belong to it, each by its name."""

    id: str
    added: str
    """Time (ISO 8601), by which parts are ordered."""
    program: str
    sheet: str = ""
    controller: str = ""
    """File of a controller."""
    tool: str = ""
    """File of a tool that bends."""
    beside: tuple[str, ...] = ()
    """Meshes, subprograms, tables."""
    reading: Reading = Reading()
    inspection: dict[str, Any] | None = None
    """None: it is to be inspected (again)."""


class Request(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is to be made of a part, as people write it."""

    machine: str
    tip_tolerance: str = ""
    axis_tolerance: str = ""
    """Empty: those that commands take without, 0.01 mm and 0.05 deg or less as the program asks."""
    feeds: str = "program"
    """program: as they are; air, learned, limits: by the cut; else as --feed has it: none, 120%, 3000mm/min."""
    air_feed: str = ""
    """In air, where feeds are by the cut; empty: what the slowest linear axis allows."""
    limits: str = ""
    """Of the cut, where feeds are by them, separated by commas: chip=0.08mm, 3:force=400N."""
    material: str = ""
    """What is cut, for limits of a force."""
    effort: str = "normal"
    tool_length: str = ""
    bend: bool = False
    """Whether the bending of the tool, by the part's file of it, is compensated."""


class AppJob(msgspec.Struct, frozen=True, kw_only=True):
    """A request, and what came of it."""

    id: str
    part: str
    number: int
    """From 1, in the order in which the jobs are done."""
    added: str
    request: Request
    reading: Reading
    state: State = "waiting"
    row: BatchRow | None = None
    """Of the batch's table, once it has ended; None where it came to nothing."""
    error: str = ""
    """One line."""
    program: str = ""
    """The program to load, from the root of the folder; empty where there is none."""
    notes: tuple[str, ...] = ()
    """What is to be said of that program."""


def cut_rules(request: Request) -> FeedRules | None:
    """The rules of feeds by the cut; None where it sets none. Raises UsageError."""
    if request.feeds not in CUT_FEEDS:
        return None
    from toolpace.common.units import parse_feed
    from toolpace.cutting.feeds.rules import FeedRules
    from toolpace.cutting.feeds.schedule import PROGRAM_STEPS
    from toolpace.cutting.forces.material import Material
    from toolpace.jobs.cut_options import cut_limits

    if request.material and request.material not in Material.names():  # no file is named in a request
        cure = did_you_mean(request.material, Material.names())
        raise UsageError(f"material '{printable(request.material[:40])}' is not known; {cure}")
    limits = {} if request.feeds != "limits" else cut_limits(limit_words(request))
    if request.feeds == "limits" and not limits:
        raise UsageError("no limit of the cut is given; add one, such as chip=0.08mm")
    rules = FeedRules(
        way=request.feeds,
        air_feed=parse_feed(request.air_feed) if request.air_feed else None,
        steps=PROGRAM_STEPS,
        limits=limits,
        materials={"": Material.load(request.material).coefficients} if request.material else {},
    )
    for tool in limits:
        rules.limits_of(tool)
    return rules


def limit_words(request: Request) -> list[str]:
    """Its limits of the cut, each as the option --limit has it."""
    return [word.strip() for word in request.limits.split(",") if word.strip()]


def command_of(part: Part, job: AppJob) -> str:
    """The command that does the same in the folder of the part's files."""
    request, reading = job.request, job.reading
    words = ["toolpace", "plan", part.program, "-m", request.machine]
    words += ["--tip-tolerance", request.tip_tolerance] if request.tip_tolerance else []
    words += ["--axis-tolerance", request.axis_tolerance] if request.axis_tolerance else []
    words += ["--effort", request.effort] if request.effort != "normal" else []
    words += ["--tool-length", request.tool_length] if request.tool_length else []
    bend = ["--bend", part.tool] if request.bend else []
    how = ["--setup", part.sheet] if part.sheet else []
    how += ["--controller", part.controller or reading.controller] if part.controller or reading.controller else []
    for name in ("dialect", "compensation", "columns", "units"):
        how += [f"--{name}", getattr(reading, name)] if getattr(reading, name) else []
    how += [f"--{name.replace('_', '-')}" for name in ("skip_unknown", "lenient") if getattr(reading, name)]
    how += ["--max-blocks", str(reading.max_blocks)] if reading.max_blocks else []
    if request.feeds in CUT_FEEDS:
        new = f"new-{part.program}"
        feeds = ["toolpace", "feeds", part.program, *words[3:], "--feeds", request.feeds, "-o", new, *how]
        feeds += ["--air-feed", request.air_feed] if request.air_feed else []
        feeds += [word for limit in limit_words(request) for word in ("--limit", limit)]
        feeds += ["--material", request.material] if request.material else []
        return f"{shlex.join(feeds)} && {shlex.join(['toolpace', 'plan', new, *words[3:], *bend, *how])}"
    return shlex.join([*words, *(["--feed", request.feeds] if request.feeds != "program" else []), *bend, *how])
