"""Figures of plans side by side, by operation and by limit, from their folders."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from toolpace.common.errors import UsageError
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.results.write import PlanRecord, read_plan

FEWEST, MOST = 2, 8
"""Plans that are compared: more are a batch."""
OperationKey = tuple[str, str, int]
"""Name and tool of an operation, and the how many-eth of these it is."""
Row = tuple[str, tuple[float | None, ...]]
"""A name, and a figure of each plan; None where a plan has no such thing."""


@dataclass(frozen=True)
class Compared:
    """Plans side by side; times in s, in the order of the plans."""

    folders: tuple[Path, ...]
    names: tuple[str, ...]
    """What tells the plans apart."""
    records: tuple[PlanRecord, ...]
    keys: tuple[OperationKey, ...]
    """Of the operations of all programs, in their order."""
    operations: tuple[Row, ...]
    """Time of each of them."""
    limits: tuple[Row, ...]
    """Time in which each limit binds, the most first: the share of the duration in plan.json, times the duration."""

    @property
    def durations(self) -> tuple[float, ...]:
        """[s]"""
        return tuple(record.duration_s for record in self.records)

    @property
    def programs_differ(self) -> bool:
        """Whether the plans are of programs of different names."""
        return len({record.program for record in self.records}) > 1


def compared(folders: Sequence[str | Path]) -> Compared:
    """Compare the plans in these folders. Raises UsageError where one is none, or they are too few or too many."""
    if not FEWEST <= len(folders) <= MOST:
        raise UsageError(f"{len(folders)} plans: give {FEWEST} to {MOST} folders that `toolpace plan` wrote")
    paths = tuple(Path(folder) for folder in folders)
    records = tuple(read_plan(path) for path in paths)
    shares = [record.limited_by for record in records]
    limits = [
        (name, tuple(share.get(name, 0.0) * record.duration_s for share, record in zip(shares, records)))
        for name in dict.fromkeys(name for share in shares for name in share)
    ]
    limits.sort(key=lambda row: -max(row[1]))
    return Compared(paths, _names(paths), records, *_operations(records), tuple(limits))


def _names(paths: Sequence[Path]) -> tuple[str, ...]:
    """The last parts of the paths, as many as it takes to tell them apart; numbers where nothing does."""
    parts = [path.resolve().parts for path in paths]
    for count in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-count:]) for part in parts]
        if len(set(names)) == len(names):
            return tuple(names)
    return tuple(f"{part[-1]} ({number})" for number, part in enumerate(parts, start=1))


def operation_keys(operations: Iterable[tuple[str, str]]) -> Iterator[OperationKey]:
    """Keys of operations of these names and tools, in order: the second of a name is the second of other plans too."""
    met: Counter[tuple[str, str]] = Counter()
    for each in operations:
        met[each] += 1
        yield *each, met[each]


def operation_words(keys: Sequence[OperationKey]) -> list[str]:
    """What each is called."""
    nameless = "before any operation" if len(keys) > 1 else "the whole program"
    found = []
    for name, tool, number in keys:
        words = " ".join(word for word in (name, f"tool {tool}" if tool else "") if word) or nameless
        found.append(words + (f", {number} of this name" if number > 1 else ""))
    return found


def _operations(records: Sequence[PlanRecord]) -> tuple[tuple[OperationKey, ...], tuple[Row, ...]]:
    """Operations with the same name and tool are the same."""
    times = [
        dict(zip(operation_keys((each.name, each.tool) for each in record.operations), _times(record)))
        for record in records
    ]
    keys = tuple(dict.fromkeys(key for found in times for key in found))
    rows = (tuple(found.get(key) for found in times) for key in keys)
    return keys, tuple(zip(operation_words(keys), rows))


def _times(record: PlanRecord) -> list[float]:
    return [each.time_s for each in record.operations]


def verdict_words(record: PlanRecord) -> str:
    """As plan.json has it; `toolpace verify` verifies again."""
    if record.verified is None:
        return "not verified"
    return "verified" if record.verified and record.usage.worst <= PROMISED else "failed"
