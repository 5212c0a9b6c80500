"""The teachers of each tool at each spindle speed: of the program itself, and of others by the same tool.

    surely cut, wide enough, at a feed of the cut      may teach
    loads held long enough                             held_loads
    none is above them in all three                    best_of
    the same without the heaviest time                 what the answer hangs on
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.files import reason, write_text
from toolpace.cutting.feeds.feed_moves import FeedMoves
from toolpace.cutting.feeds.learned import Taken, Teacher, best_of, held_loads, without_heaviest
from toolpace.cutting.simulation.operation_cut import CutStretch
from toolpace.programs.tool_figures import ToolFigures

WIDE = 3.0
"""Cells that a contact is wide or deep at least, to teach: what is narrower is known too coarsely."""
SHARE = 0.1
"""Of the volume of a tool that is removed at a feed at least, for it to be a feed at which the tool cuts."""
HEAVIEST = 0.01
"""Share of the time that is left out to see what the answer hangs on."""
NEARLY = 0.9
"""Share of a teacher's loads that count as its own, for how long they are taken."""
SAME_SPEED = 1e-6
"""Share by which spindle speeds of two programs may differ by rounding."""
FILE = "teachers.json"
NOT_OF_THE_TOOL = ("source", "assumed", "spindle_speed", "spindle_range", "cutting_speed", "stability")
"""Figures of a tool that two programs may tell in different ways."""


@dataclass(frozen=True)
class Taught:
    """What one tool at one spindle speed is known to bear."""

    best: Taken
    hardly: Taken
    """The same without the heaviest time of this program."""
    teachers: tuple[Teacher, ...]
    """Those of `best`."""


NOTHING = Taught(Taken.joined([]), Taken.joined([]), ())


def taught(moves: FeedMoves) -> dict[tuple[str, float], Taught]:
    """The teachers of each tool at each spindle speed [1/s]."""
    loads: dict[tuple[str, float], list[tuple[CutStretch, Taken]]] = defaultdict(list)
    usual = cutting_feeds(moves)
    for k, stretch in enumerate(moves.stretches):
        tool, before = moves.tool(stretch), moves.before[k]
        may = _may_teach(moves, stretch) & (before <= usual.get(tool, 0.0) * (1.0 + 1e-9))
        speed = np.minimum(moves.speed_reached(stretch), np.maximum(before, 1e-9))
        for turns, at in moves.by_spindle(stretch, may) if may.any() else ():
            forces = moves.forces(stretch, stretch.certain, turns)
            loads[tool, turns].append((stretch, held_loads(forces, speed, moves.places[k].way, at)))
    found = {key: _taught(moves, key, each) for key, each in loads.items()}
    return _with_others(moves, found)


def _may_teach(moves: FeedMoves, stretch: CutStretch) -> Bools:
    """(n,) stations that are surely cut, wide enough, and not left out by name or line."""
    wide = np.maximum(stretch.certain.width, stretch.certain.depth) > WIDE * stretch.resolution
    lines = [int(each) for each in moves.rules.not_teaching if each.isdigit()]
    if moves.operation(stretch) in moves.rules.not_teaching:
        return np.zeros(len(wide), dtype=np.bool_)
    return stretch.cutting & wide & ~np.isin(stretch.stations.block, lines)


def _taught(moves: FeedMoves, key: tuple[str, float], parts: list[tuple[CutStretch, Taken]]) -> Taught:
    """Of one tool at one spindle speed: what was found in each stretch."""
    begins = np.cumsum([0, *(len(stretch.stations) for stretch, _ in parts)])
    every = Taken.joined(
        [Taken(each.chip, each.area, each.edge, begin + each.station) for begin, (_, each) in zip(begins, parts)]
    )
    seconds = np.concatenate([stretch.seconds for stretch, _ in parts])
    lines = np.concatenate([stretch.stations.block for stretch, _ in parts])
    names = [moves.operation(stretch) for stretch, _ in parts]
    best, figures = best_of(every), figures_as_text(moves.figures(parts[0][0]))
    part = np.searchsorted(begins, best.station, side="right") - 1
    listed = tuple(
        Teacher(
            int(lines[at]), names[int(part[k])], key[0], float(best.chip[k]), float(best.area[k]), float(best.edge[k]),
            _time_of(every, seconds, best, k), key[1], figures=figures,
        )
        for k, at in enumerate(best.station.tolist())
    )  # fmt: skip
    return Taught(best, best_of(without_heaviest(every, seconds[every.station], HEAVIEST)), listed)


def _time_of(every: Taken, seconds: Floats, best: Taken, k: int) -> float:
    """How long nearly the loads of the k-th are taken [s]."""
    near = (
        (every.chip >= NEARLY * best.chip[k]) & (every.area >= NEARLY * best.area[k])
        & (every.edge >= NEARLY * best.edge[k])
    )  # fmt: skip
    stations: Ints = np.unique(every.station[near])
    return float(seconds[stations].sum())


def cutting_feeds(moves: FeedMoves) -> dict[str, float]:
    """Of each tool the highest feed at which it surely cuts SHARE of all that it removes [m/s]."""
    by_tool: dict[str, list[tuple[Floats, Floats]]] = defaultdict(list)
    for stretch, before in zip(moves.stretches, moves.before):
        by_tool[moves.tool(stretch)].append((before, stretch.certain.removed))
    found = {}
    for tool, parts in by_tool.items():
        feed, removed = (np.concatenate([part[k] for part in parts]) for k in range(2))
        order = np.argsort(-feed, kind="stable")
        enough = np.cumsum(removed[order]) >= SHARE * removed.sum()
        found[tool] = float(feed[order][enough.argmax()]) if removed.sum() > 0.0 else 0.0
    return found


# Other programs


def _with_others(moves: FeedMoves, found: Mapping[tuple[str, float], Taught]) -> dict[tuple[str, float], Taught]:
    """With the teachers of other programs, for tools with the same name, figures and spindle speed."""
    together = dict(found)
    if not moves.rules.teachers:
        return together
    keys = {(moves.tool(each), turns) for each in moves.stretches for turns, _ in moves.by_spindle(each)}
    figures = {moves.tool(each): figures_as_text(moves.figures(each)) for each in moves.stretches}
    for key in sorted(keys):
        others = tuple(
            each for each in moves.rules.teachers
            if each.tool == key[0] and each.figures == figures[key[0]]
            and abs(each.spindle_speed - key[1]) <= SAME_SPEED * abs(key[1])
        )  # fmt: skip
        if others:
            chip, area, edge = np.array([(each.chip, each.area, each.edge) for each in others]).T
            taken = Taken(chip, area, edge, np.full(len(others), -1))
            own = together.get(key, NOTHING)
            best, hardly = (best_of(Taken.joined([each, taken])) for each in (own.best, own.hardly))
            together[key] = Taught(best, hardly, (*own.teachers, *others))
    return together


def figures_as_text(figures: ToolFigures) -> dict[str, str]:
    """Those by which a tool of another program is told to be the same."""
    names = [each.name for each in fields(figures) if each.name not in NOT_OF_THE_TOOL]
    return {name: repr(getattr(figures, name)) for name in names}


def save_teachers(teachers: Iterable[Teacher], program: str, folder: str | Path) -> None:
    """Write the teachers of a program for others (`load_teachers`), as teachers.json of a folder, which is made.

    Raises UsageError where it cannot be.
    """
    entries = [asdict(each) | {"program": each.program or program} for each in teachers]
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        write_text(Path(folder) / FILE, json.dumps({"teachers": entries}, indent=1))
    except OSError as error:
        raise UsageError(f"--save-teachers {folder}: {reason(error)}; give another folder") from None


def load_teachers(folder: str | Path) -> tuple[Teacher, ...]:
    """The teachers that `save_teachers` wrote. Raises UsageError where there are none, or the file is damaged."""
    file = Path(folder) / FILE
    if not file.is_file():
        raise UsageError(f"--teacher {folder}: has no {FILE}; feeds --feeds learned --save-teachers FOLDER writes it")
    try:
        entries = json.loads(file.read_text("utf-8"))["teachers"]
        return tuple(_teacher(each) for each in entries)
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{file}: is no file of teachers ({error}); write it anew with --save-teachers") from None


def _teacher(entry: Mapping[str, object]) -> Teacher:
    """One of a file. Raises ValueError, TypeError."""
    found = Teacher(**entry)  # type: ignore[arg-type]
    loads = (found.chip, found.area, found.edge, found.seconds, found.spindle_speed)
    if not all(isinstance(each, int | float) and np.isfinite(each) for each in loads):
        raise ValueError("a load is no number")
    if not (found.chip > 0.0 and found.area > 0.0 and found.edge > 0.0):
        raise ValueError("a load is not above zero")
    return found


def by_line(teachers: Sequence[Teacher]) -> tuple[Teacher, ...]:
    """One of each line and tool, that with the largest area of chips; the largest first."""
    heaviest: dict[tuple[str, int, str], Teacher] = {}
    for each in sorted(teachers, key=lambda each: -each.area):
        heaviest.setdefault((each.program, each.line, each.tool), each)
    return tuple(heaviest.values())
