"""Why a random plan costs more than others a point: from its row, or where that does not tell, from planning it again.

A row tells how many points there are, what the path takes, and what the planner notes. What it did (`Work`) tells the
rest: solves that do not come to their end, another try, rounds between the nodes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any

FEW = 300
"""Points of a mesh up to which a plan costs about the same, however few they are: a round of it takes milliseconds."""
MOSTLY = 0.5
"""Share of a plan's time from which something is its cause."""
AS_GIVEN = "the mesh is kept as it was given"
"""End of a note after which nothing was tried, and no time spent."""
Row = dict[str, Any]


@dataclass
class Work:
    """What the planner does: how often, and the CPU time it takes [s]."""

    solves: int = 0
    steps: int = 0
    solving: float = 0.0
    unended: int = 0
    """Solves that did not come to the optimum."""
    in_vain: float = 0.0
    bounding: float = 0.0
    """By relaxations, those of proofs included."""
    looks: int = 0
    """Between the nodes."""
    trying: float = 0.0
    """By another try, with the solves and relaxations in it."""

    def split(self, cpu: float, path: float) -> str:
        """What a plan's time is made of, in words."""
        solving, bounding, along = (each / cpu for each in (self.solving, self.bounding, path))
        return (
            f"{self.solves} solves of {self.steps} steps take {solving:.0%}, the bound {bounding:.0%}, the path"
            f" {along:.0%}, {self.looks} looks between the nodes and the mesh {1.0 - solving - bounding - along:.0%}"
        )


@contextmanager
def watched() -> Iterator[Work]:
    """What the planner does from now on."""
    from toolpace.kernels.optimal import relaxation, solver
    from toolpace.planning.optimal import inter_sample_limits, planner

    work = Work()

    def solved(cpu: float, found: Any) -> None:
        ended = found[1] == solver.OPTIMAL
        work.solves, work.steps, work.solving = work.solves + 1, work.steps + int(found[2]), work.solving + cpu
        if not ended:
            work.unended, work.in_vain = work.unended + 1, work.in_vain + cpu

    def bounded(cpu: float, _: Any) -> None:
        work.bounding += cpu

    def looked(_: float, __: Any) -> None:
        work.looks += 1

    def tried(cpu: float, _: Any) -> None:
        work.trying += cpu

    # what is called by this name at each call; kernels take the time of their thread, another try that of all
    places: list[tuple[Any, str, Callable[[], float], Callable[[float, Any], None]]] = [
        (solver, "maximise_speed", time.thread_time, solved), (relaxation, "relax", time.thread_time, bounded),
        (inter_sample_limits, "checked_between_nodes", time.thread_time, looked),
        (planner, "fallback_plan", time.process_time, tried),
    ]  # fmt: skip
    before = [getattr(module, name) for module, name, _, _ in places]
    for (module, name, clock, told), function in zip(places, before):
        setattr(module, name, told_of(function, clock, told))
    try:
        yield work
    finally:
        for (module, name, _, _), function in zip(places, before):
            setattr(module, name, function)


def told_of(
    function: Callable[..., Any], clock: Callable[[], float], tell: Callable[[float, Any], None]
) -> Callable[..., Any]:
    """The function, each call's CPU time and result being told."""

    def telling(*given: Any, **named: Any) -> Any:
        began = clock()
        result = function(*given, **named)
        tell(clock() - began, result)
        return result

    return telling


def cause(row: Row, slow: float, few: float) -> str:
    """Why a plan takes more than `slow` for each of its points; "" where it does not, or its row does not tell.

    `few`: three times what a plan on few points takes in all, in the median [s].
    """
    points, cpu = row["points"], row["cpu"]
    if cpu <= slow * points:
        return ""
    if points <= FEW and cpu <= few:
        return f"few points: {cpu * 1e3:.0f} ms in all"
    own = row.get("path_cpu", 0.0)
    if enough(own, cpu, slow * points):
        return f"the path: {own / points * 1e6:.0f} microseconds a point"
    work = Work(**row["work"]) if "work" in row else None
    if work and enough(work.in_vain, cpu, slow * points):
        return (
            f"solves without an end: {work.unended} of {work.solves} come to none, and take {work.in_vain / cpu:.0%}"
            " of the time"
        )
    tries = [note for note in row.get("notes", []) if not note.endswith(AS_GIVEN)]
    if tries and (work is None or enough(work.trying, cpu, slow * points)):
        return "another try: " + "; ".join(tries)
    return f"all of it: {work.split(cpu, own)}" if work else ""


def enough(part: float, cpu: float, allowed: float) -> bool:
    """Whether a part of a plan's time is what makes it slow: most of it, or slow no longer without."""
    return part > MOSTLY * cpu or cpu - part <= allowed


def cause_by_planning_again(row: Row, again: Row, slow: float, few: float) -> str:
    """The cause of a slow plan, from the row that planning it once more made; never ""."""
    if again["cpu"] <= slow * again["points"]:
        return f"the machine: planned again it takes {again['cpu'] / again['points'] * 1e6:.0f} microseconds a point"
    return cause(again | {"notes": row.get("notes", [])}, slow, few)


def work_of(work: Work) -> dict[str, float]:
    """It, for a row."""
    return asdict(work)
