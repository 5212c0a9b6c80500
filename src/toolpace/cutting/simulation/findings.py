"""What is wrong with a cut: each finding with its block, operation, depth and place, the worst first."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.cutting.engagement.stations import Stations
from toolpace.cutting.simulation.left_above_part import LeftRegion
from toolpace.programs.toolpath import Operation

FindingKind = Literal["rapid", "holder", "shank", "gouge", "flute", "left", "air"]
COLLISIONS: tuple[FindingKind, ...] = ("rapid", "holder", "shank", "gouge", "flute")
"""Kinds that spoil tool, part or machine: the command ends with 1. What cuts air only wastes time, and what is left may
be for another program."""
WORDS: dict[FindingKind, str] = {
    "rapid": "rapid through",
    "holder": "holder in",
    "shank": "shank in",
    "gouge": "cuts into",
    "flute": "cuts above its flutes in",
    "left": "material left above",
    "air": "feed in air, never in",
}
STOCK, PART = "stock", "finished part"
"""Bodies that are met; a fixture is "fixture NAME"."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, in one block."""

    kind: FindingKind
    line: int
    """Line of the program."""
    operation: str
    tool: str
    body: str
    """What is met: the stock, the finished part, or a fixture by its name."""
    depth: float
    """How deep in it, at the worst place [m]; 0 of `air`; of `left` how high above it."""
    place: tuple[float, float, float]
    """Of the tip, there, in the frame of the part [m]; of `left` of the material itself."""
    time: float
    """When it is passed [s]."""
    seconds: float
    """How long the block is in that state [s]."""
    last_line: int
    """The same as `line`, but of `air`: the last of the blocks that cut nothing, one after the other."""
    certain: bool = True
    """Whether it is so wherever, within its uncertainty, the stock ends."""

    @property
    def collision(self) -> bool:
        """Whether it spoils tool, part or machine."""
        return self.kind in COLLISIONS


class FeedWay(NamedTuple):
    """Stations at feed of one operation."""

    stations: Stations
    name: str
    tool: str


@dataclass(frozen=True)
class Contact:
    """A body that the tool is in along stations, as it is found."""

    kind: FindingKind
    body: str
    depth: Floats
    """(n,) [m]; 0 or less where there is no contact."""
    certain: Bools
    """(n,) whether it is there in any case."""


def findings_of(
    stations: Stations, contacts: Iterable[Contact], operation: str, tool: str
) -> list[Finding]:
    """The findings of a stretch of stations: of each contact one for each block.

    The first station is where the stretch before ends, and counts there; but for the first of all.
    """
    seconds = stations.moving_time
    counts = np.arange(len(stations)) > 0
    counts[0] = len(stations) == 1 or stations.time[0] <= 0.0
    found = []
    for contact in contacts:
        there = (contact.depth > 0.0) & counts
        for block in np.unique(stations.block[there]).tolist():
            at = np.flatnonzero(there & (stations.block == block))
            worst = int(at[np.argmax(contact.depth[at])])
            found.append(
                Finding(
                    kind=contact.kind,
                    line=block,
                    operation=operation,
                    tool=tool,
                    body=contact.body,
                    depth=float(contact.depth[worst]),
                    place=_place(stations, worst),
                    time=float(stations.time[worst]),
                    seconds=float(seconds[at].sum()),
                    last_line=block,
                    certain=bool(contact.certain[at].any()),
                )
            )
    return found


class Stretch(Protocol):
    """Neighbouring stations, all at feed or all at rapid."""

    @property
    def stations(self) -> Stations: ...
    @property
    def operation(self) -> int: ...
    @property
    def rapid(self) -> bool: ...
    @property
    def air(self) -> Bools: ...


def air_findings(stretches: Sequence[Stretch], operations: Sequence[Operation]) -> list[Finding]:
    """Blocks at feed that cut nothing from their begin to their end: of neighbours one finding.

    stretches: in the order of time. A block that rapids part, as a cycle that pecks, cuts where one of its parts does.
    """
    found: list[Finding] = []
    executions = _executions(stretches)
    feeds = [(each, of) for each, of in zip(stretches, executions) if not each.rapid]
    cutting = np.unique(np.concatenate([np.zeros(0, np.int64), *(of[1:][~each.air[1:]] for each, of in feeds)]))
    for each, of in feeds:
        operation = operations[each.operation]
        air = each.air & ~np.isin(of, cutting)
        found += _air_of(each.stations, air, operation.name, operation.tool)
    return found


def _executions(stretches: Sequence[Stretch]) -> list[Ints]:
    """Of each stretch, for its stations (n,), which of all executions of blocks they belong to."""
    found: list[Ints] = []
    number, last = 0, (-1, -1)
    for each in stretches:
        blocks = each.stations.block[1:]
        before = last[1] if last[0] == each.operation else -1
        of = number + np.concatenate([[0], np.cumsum(np.diff(blocks, prepend=before) != 0)])
        found.append(of)
        number = int(of[-1])
        last = each.operation, int(blocks[-1]) if len(blocks) else before
    return found


def _air_of(stations: Stations, air: Bools, operation: str, tool: str) -> list[Finding]:
    """The findings of a stretch at feed."""
    seconds = stations.moving_time
    head = np.flatnonzero(np.diff(stations.block[1:], prepend=-1)) + 1
    found: list[Finding] = []
    before = -1
    for k, (first, last) in enumerate(zip(head, [*head[1:].tolist(), len(stations.block)])):
        if not air[first:last].all():
            continue
        took = float(seconds[first:last].sum())
        line = int(stations.block[first])
        if before == k - 1 and found:
            whole = found.pop()
            found.append(
                Finding(
                    "air", whole.line, operation, tool, STOCK, 0.0, whole.place, whole.time, whole.seconds + took, line
                )
            )
        else:
            place, time = _place(stations, first - 1), float(stations.time[first - 1])
            found.append(Finding("air", line, operation, tool, STOCK, 0.0, place, time, took, line))
        before = k
    return found


def left_findings(regions: Sequence[LeftRegion], certain: Bools, feeds: Sequence[FeedWay]) -> list[Finding]:
    """What is left above the finished part, each region with the block whose tip comes nearest to it.

    certain: (k,) whether it is left wherever the stock ends. feeds: the ways at feed; none: no block is named.
    """
    from scipy.spatial import cKDTree

    if not regions:
        return []
    tips = np.concatenate([np.zeros((0, 3)), *(each.stations.tip for each in feeds)])
    which = np.repeat(np.arange(len(feeds)), [len(each.stations) for each in feeds])
    first = np.cumsum([0, *(len(each.stations) for each in feeds)])
    tree, found = cKDTree(tips), []
    for region, sure in zip(regions, certain.tolist()):
        line, name, tool, time = 0, "", "", 0.0
        k = int(tree.query(region.place)[1])
        if k < len(tips):
            way = feeds[which[k]]
            at = int(k - first[which[k]])
            line, time = int(way.stations.block[at]), float(way.stations.time[at])
            name, tool = way.name, way.tool
        x, y, z = region.place.tolist()
        found.append(Finding("left", line, name, tool, PART, region.height, (x, y, z), time, 0.0, line, sure))
    return found


def worst_first(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Collisions before the rest, those that are certain before those that may be, the deepest and longest first.

    Blocks that a rapid parts into several stretches have one finding, that of their worst place.
    """
    merged: dict[tuple[str, str, int, str], Finding] = {}
    for each in findings:
        key = (each.kind, each.body, each.line, each.operation)
        before = merged.get(key)
        if before is None or each.depth > before.depth or (each.kind == "air" and each.seconds > before.seconds):
            merged[key] = each
    return tuple(
        sorted(merged.values(), key=lambda each: (not each.collision, not each.certain, -each.depth, -each.seconds))
    )


def _place(stations: Stations, at: int | np.integer[Any]) -> tuple[float, float, float]:
    x, y, z = stations.tip[at].tolist()
    return x, y, z
