"""Where the planner puts its nodes: evenly in time, finer next to rest and where the path turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.axispath import AxisRun
from toolpace.kernels import envelope
from toolpace.limits import Limits
from toolpace.plan.detail import allowed, closer_look

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

STEPS_A_RAMP = 8.0
"""Nodes for the time in which the acceleration of the slowest joint builds up."""
GRADING = 0.1
"""Largest step in time next to rest, as a share of the time since rest."""
CELLS_A_HINT = 2.0
"""Fewest cells between two hints of a run, such as the knots of a fitted path."""
FEWEST_CELLS = 150
DEFAULT_CELLS = 1500
MOST_CELLS = 20_000
"""Fewest cells of a run, with hints and without, and most, unless it has many hints or turns."""
CELLS_A_PLACE = 20
"""Most cells for each hint, or for each of the places that it takes to tell the speed between them."""
ROUGH, ROUGH_BY = 0.05, 1.5
"""Share of the intervals between such places, beyond which more are needed, and the factor that makes one rough."""
SAMPLES = 4000
MOST_PLACES = 4_000_000
"""Intervals that are looked at, and most places."""
FLEETING = 1e-5
"""Share of the time in which the whole run would be passed at the highest ds/dt of a guess: more would gain nothing."""
NODES_A_FALL = 1.0
"""Fewest nodes while z falls or grows by the factor e: where the motion nearly stops, steps in time are too long."""
ONE_PLACE = 1e-4
"""Share of a cell up to which breaks are one place: cells that short spoil the spline, and nothing happens in them."""
CHUNK = 20_000
"""Points of a path that are worked out at a time, to keep memory low."""


@dataclass(frozen=True)
class Guess:
    """A first idea of the motion along a run, on a fine grid."""

    s: Floats
    z: Floats
    """(n,) (ds/dt)^2, well within the limits but for its kinks."""
    t: Floats
    """(n,) time [s]."""
    highest: float
    """The highest z that the limits allow anywhere at steady speed."""
    detail: Floats
    """(k,) those s that only a closer look has found to be needed."""


def guess(run: AxisRun, limits: Limits, ends: tuple[float, float], resolution: int) -> Guess:
    """The speed that pointwise limits and jerk-limited ramps allow; `ends` are the given z, 0 at rest."""
    length = run.s1 - run.s0
    graded = run.s0 + length * from_graded(np.linspace(0.0, 1.0, resolution + 1), ends)
    s = np.unique(np.concatenate([graded, run.hints, run.breaks]))
    s = s[(s >= run.s0) & (s <= run.s1)]
    keep = np.concatenate([[True], np.diff(s) > 1e-12 * length])
    keep |= np.isin(s, run.breaks)
    s = s[keep]
    s[-1] = run.s1
    looks = [closer_look(run, limits, s[i : i + CHUNK + 1]) for i in range(0, len(s) - 1, CHUNK)]
    closer = np.concatenate([between.s for _, between in looks])
    # the last point of a chunk is the first of the next, where its left side is not seen any more
    s, first = np.unique(np.concatenate([part.s for look in looks for part in look]), return_index=True)
    steady = np.concatenate([part.steady for look in looks for part in look])[first]
    third = np.concatenate([part.third for look in looks for part in look])[first]
    highest = highest_of(steady, length)
    finite = np.isfinite(steady)
    if not finite.all():
        steady[~finite] = 1e6 * (steady[finite].max() if finite.any() else (length / 1e-6) ** 2)
    third = np.where(np.isfinite(third), third, 1e6 * np.min(third, initial=length / 1e-9))
    z = envelope.ramped(s, steady, third, ends[0], ends[1])
    # where nothing moves, or nearly so, ds/dt would be without bounds
    fastest = (length / (FLEETING * envelope.times(s, z)[-1])) ** 2
    z = np.minimum(z, fastest)
    return Guess(s, z, envelope.times(s, z), min(highest, fastest), closer)


def steady_speed(run: AxisRun, limits: Limits, s: Floats) -> tuple[Floats, Floats]:
    """(n,) z that all limits allow at steady speed, and (n,) the most d3s/dt3 they allow at rest."""
    steady, third = np.empty(len(s)), np.empty(len(s))
    for i in range(0, len(s), CHUNK):
        part = s[i : i + CHUNK]
        steady[i : i + CHUNK], third[i : i + CHUNK] = allowed(run, limits, part, run.evaluate(part))
    return steady, third


def highest_of(steady: Floats, length: float) -> float:
    """The highest of the z (n,) that limits allow at steady speed; a large value where there are no limits."""
    finite = np.isfinite(steady)
    return float(steady[finite].max()) if finite.any() else (length / 1e-6) ** 2


def places(run: AxisRun, limits: Limits, fewest: int) -> int:
    """How many even places along a run tell the speed between them: `fewest`, or more where it turns often."""
    count = fewest
    while count < MOST_PLACES:
        interval = np.unique(np.linspace(0, count - 1, min(SAMPLES, count)).astype(np.int64))
        # anywhere in the interval, lest a regular path is met in step
        inside = interval * 0.6180339887498949 % 1.0
        left, right, there = (
            np.sqrt(steady_speed(run, limits, run.s0 + (run.s1 - run.s0) * (interval + x) / count)[0])
            for x in (0.0, 1.0, inside)
        )
        low, high = np.minimum(left, right) / ROUGH_BY, np.maximum(left, right) * ROUGH_BY
        if np.mean((there < low) | (there > high)) <= ROUGH:
            break
        count *= 4
    return count


def ramp_time(limits: Limits) -> float:
    """Time in which an acceleration builds up [s]: of the quickest joint; inf where none is limited."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ramps = limits.acceleration / limits.jerk
    usable = ramps[np.isfinite(ramps) & (ramps > 0.0)]
    return float(usable.min()) if len(usable) else np.inf


def from_graded(x: Floats, ends: tuple[float, float]) -> Floats:
    """Place in [0, 1] of evenly spaced x in [0, 1]: next to an end at rest it goes like the cube of the distance."""
    if ends[0] == 0.0 and ends[1] == 0.0:
        return x**3 / (x**3 + (1.0 - x) ** 3)
    if ends[0] == 0.0:
        return x**3
    return 1.0 - (1.0 - x) ** 3 if ends[1] == 0.0 else x


def to_graded(place: Floats, ends: tuple[float, float]) -> Floats:
    """The inverse of `from_graded`."""
    left: Floats = np.cbrt(place)
    right: Floats = np.cbrt(1.0 - place)
    if ends[0] == 0.0 and ends[1] == 0.0:
        return left / (left + right)
    if ends[0] == 0.0:
        return left
    return 1.0 - right if ends[1] == 0.0 else place


def first_mesh(run: AxisRun, limits: Limits, ends: tuple[float, float], cells: int | None) -> tuple[Floats, Guess]:
    """Nodes (n,) from s0 to s1; `cells` fixes their number, else time decides it; breaks and detail come on top."""
    fewest = cells or (FEWEST_CELLS if len(run.hints) else DEFAULT_CELLS)
    many = places(run, limits, fewest) if cells is None and not len(run.hints) else fewest
    rough = guess(run, limits, ends, many)
    s, t = rough.s, rough.t
    total = t[-1]
    step = total / fewest
    most = max(MOST_CELLS, CELLS_A_PLACE * max(len(run.hints), many if many > fewest else 0))
    if cells is None:
        step = min(step, max(ramp_time(limits) / STEPS_A_RAMP, total / most))
    # nodes a unit of time: even, but no coarser than GRADING next to rest
    middle = (t[1:] + t[:-1]) / 2.0
    density = np.full(len(middle), 1.0 / step)
    for distance, z in ((middle, ends[0]), (total - middle, ends[1])):
        if z == 0.0:
            density = np.maximum(density, 1.0 / (GRADING * np.maximum(distance, step)))
    count = np.diff(t) * density
    moves = (middle > (step if ends[0] == 0.0 else 0.0)) & (middle < total - (step if ends[1] == 0.0 else 0.0))
    fall = np.abs(np.diff(np.log(np.maximum(rough.z, 1e-300))))
    count = np.where(moves, np.maximum(count, NODES_A_FALL * fall), count)
    if cells is None and len(run.hints):
        # between two hints the third derivative bends, unless they are one place
        hints = np.unique(np.concatenate([[run.s0], run.hints, [run.s1]]))
        inside = np.clip(np.searchsorted(hints, (s[1:] + s[:-1]) / 2.0) - 1, 0, len(hints) - 2)
        share = np.diff(s) / np.diff(hints)[inside]
        count = np.maximum(count, np.minimum(CELLS_A_HINT * share, np.diff(t) / (ONE_PLACE * step)))
    else:
        count += 0.25 * count.sum() * np.diff(s) / (run.s1 - run.s0)
    measure = np.concatenate([[0.0], np.cumsum(count)])
    wanted = cells if cells is not None else max(fewest, int(np.ceil(measure[-1])))
    outer = [step if z == 0.0 else 0.0 for z in ends]
    first, last = np.interp([outer[0], total - outer[1]], t, measure)
    inner = wanted - sum(z == 0.0 for z in ends)
    length = run.s1 - run.s0
    graded = to_graded((s - run.s0) / length, ends)
    nodes = run.s0 + length * from_graded(np.interp(np.linspace(first, last, inner + 1), measure, graded), ends)
    nodes = np.concatenate([[run.s0] if ends[0] == 0.0 else [], nodes, [run.s1] if ends[1] == 0.0 else []])
    nodes[0], nodes[-1] = run.s0, run.s1
    nodes = with_breaks(nodes, rough.detail, 0.0)
    knots = run.breaks if cells is not None else np.union1d(run.breaks, run.hints)
    return with_breaks(nodes, knots), rough


def with_breaks(nodes: Floats, breaks: Floats, one_place: float = ONE_PLACE) -> Floats:
    """The same nodes with the breaks among them, the nearest node moved where it lies within a third of a cell.

    Breaks closer together than the share `one_place` of the cells there become one node.
    """
    cell = np.diff(nodes)
    least = one_place * cell[np.clip(np.searchsorted(nodes, breaks) - 1, 0, len(cell) - 1)]
    inside = (breaks > nodes[1] + least) & (breaks < nodes[-2] - least)
    breaks = breaks[inside & (np.diff(breaks, prepend=-np.inf) > least)]
    if len(breaks) == 0:
        return nodes
    inner = nodes[2:-2]
    k = np.clip(np.searchsorted(breaks, inner), 1, len(breaks)) - 1
    near = np.minimum(np.abs(inner - breaks[k]), np.abs(inner - breaks[np.minimum(k + 1, len(breaks) - 1)]))
    keep = near > 0.34 * np.minimum(np.diff(nodes)[1:-2], np.diff(nodes)[2:-1])
    return np.unique(np.concatenate([nodes[:2], inner[keep], breaks, nodes[-2:]]))


def split(nodes: Floats, parts: Ints) -> Floats:
    """The nodes with each cell cut into `parts` (n - 1,) equal cells."""
    cell = np.repeat(np.arange(len(parts)), parts)
    first = np.concatenate([[0], np.cumsum(parts)[:-1]])
    share = (np.arange(len(cell)) - first[cell]) / parts[cell]
    return np.append(nodes[cell] + share * np.diff(nodes)[cell], nodes[-1])
