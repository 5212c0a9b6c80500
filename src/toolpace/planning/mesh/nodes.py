"""Mesh nodes even in time, finer near rest and where the path turns."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints, frozen
from toolpace.kernels.optimal import first_guess
from toolpace.machine.limits import Limits
from toolpace.path.axis_run import AxisRun
from toolpace.planning.mesh.initial_guess import CHUNK, Guess, from_graded, guess, places, ramp_time, to_graded

STEPS_A_RAMP = 8.0
"""Nodes for the time in which the acceleration of the slowest joint builds up."""
UNTOLD_RAMP = 0.1
"""That time, in the finest steps of a first mesh, below which even these do not tell a ramp."""
GRADING = 0.1
"""Largest step in time next to rest, as a share of the time since rest."""
AT_CAP, IN_USE = 1e-3, 0.5
"""How far z may be below its cap by feed and velocity, relative to it, and the share of acceleration and jerk that may
be in use, where z follows the cap whatever the mesh."""
RAMPS_FINE, COARSEST = 2.0, 16.0
"""Ramp times before and after any other place within which steps are as fine as at it, and how many steps a cell may
be long further away: as much as two ramps. After one ramp time cells have to be cut again where the motion leaves the
cap, which takes longer than it saves; after three a tenth of what is gained is lost. Durations differ by up to 6e-5
either way with 8 and with 16 steps.
"""
STRAIGHT = 1e-3
"""How far z at a cap may be from a straight line in such a cell, relative to it: a cubic is nearer by a hundred times.
Without it, caps in waves of 1 to 50 percent that long cells miss cost up to 2.4e-3 of the duration."""
NEXT_TO_REST = 1e-12
"""Share of the largest z below which what z bends by is not measured: there steps are fine for other reasons."""
CELLS_A_HINT = 2.0
"""Fewest cells between two hints of a run, such as the knots of a fitted path."""
SMOOTH = 1e-4
"""Share of a limit that the path may do between two hints beyond what it tells at both, for those between them to be
left out. A fit has knots every few tolerances, also where a rapid is smooth for metres: of 18 730 hints of such a run
a few hundred are left, its mesh falls from 43 582 to 2505 nodes, and the motion is the same to 1e-6. Others come out
faster or slower by up to 1e-4 as nodes move; with 1e-3 and 2e-2 mostly slower, by up to 1e-4 and 2e-4."""
FEWEST_LOOKS = 400
"""Fewest places at which a run is looked at before its mesh is made: between two of them nothing must hide."""
FEWEST_CELLS = 150
DEFAULT_CELLS = 1500
MOST_CELLS = 10_000
"""Fewest cells of a run, with hints and without, and most, unless it has many hints or turns."""
CELLS_A_PLACE = 20
"""Most cells for each hint, or for each of the places that it takes to tell the speed between them."""
NODES_A_FALL = 1.0
"""Fewest nodes while z falls or grows by the factor e: where the motion nearly stops, steps in time are too long."""
EVEN_SHARE = 0.25
"""Nodes that lie evenly along the run, as a share of the others: a fifth of all, for what the guess does not see."""
ONE_PLACE = 1e-4
"""Share of a cell up to which breaks are one place: cells that short spoil the spline, and nothing happens in them."""
NARROWEST = 1e-5
"""The same of breaks, and of places where more happens than even nodes would tell: of a cell that is shorter, z'' times
its square is no more than the rounding of z."""
MOST_UNLIKE = 8.0
"""Most ratio of the lengths of two cells side by side."""
SHORTEST = 1e5
"""Shortest cell of a first mesh, as a multiple of the rounding of s: a spline over shorter ones is noise."""


def first_mesh(run: AxisRun, limits: Limits, ends: tuple[float, float], cells: int | None) -> tuple[Floats, Guess]:
    """Nodes (n,) from s0 to s1, and the guess they come from; `ends` are the given z, 0 at rest.

    `cells` fixes their number, else time decides it. How many nodes each cell of the guess's grid gets:
      as many as are even in time, and more next to rest;
      at least so many where z falls or grows by much;
      at least so many between two hints, or, where there are none, a fifth of all evenly along the run.
    Breaks and what only a closer look has found come on top.
    """
    hints = run.hints
    fewest = cells or (FEWEST_CELLS if len(run.hints) else DEFAULT_CELLS)
    many = places(run, limits, fewest) if cells is None and not len(run.hints) else fewest
    rough = guess(run, limits, ends, max(many, FEWEST_LOOKS))
    step = rough.t[-1] / fewest
    if cells is None:
        most = max(MOST_CELLS, CELLS_A_PLACE * max(len(run.hints), many if many > fewest else 0))
        ramp, least = ramp_time(limits), rough.t[-1] / most
        # where even the finest steps could not tell a ramp, cells are cut where there is one
        step = min(step, max(ramp / STEPS_A_RAMP, least)) if ramp > UNTOLD_RAMP * least else step
    count = even_in_time(rough.t, ends, step)
    if cells is None:
        count = np.minimum(count, np.maximum(count / steps_a_cell(run, limits, rough), where_z_bends(rough)))
    count = finer_where_z_falls(count, rough, ends, step)
    if cells is None and len(run.hints):
        hints = needed_hints(run, limits, rough)
        count = np.maximum(count, between_hints(run, hints, rough, step))
    else:
        count += EVEN_SHARE * count.sum() * np.diff(rough.s) / (run.s1 - run.s0)
    measure = np.concatenate([[0.0], np.cumsum(count)])
    wanted = cells if cells is not None else max(fewest, int(np.ceil(measure[-1])))
    nodes = spread_nodes(run, rough, measure, wanted, ends, step)
    nodes = apart(with_breaks(nodes, rough.detail, NARROWEST))
    if cells is None:
        nodes = with_breaks(nodes, hints)
    return graded(with_breaks(nodes, run.breaks, NARROWEST)), rough


def shortest_cell(nodes: Floats) -> float:
    """Length of the shortest cell between nodes like these that numbers tell well."""
    return SHORTEST * float(np.spacing(np.abs(nodes).max()))


def apart(nodes: Floats) -> Floats:
    """The nodes without those that lie closer to the one before, or to the end, than numbers tell well."""
    least = shortest_cell(nodes)
    inner = nodes[1:-1]
    # cells of a grid of that length: of each the first node
    inner = inner[np.diff(np.floor((inner - nodes[0]) / least), prepend=0.0) > 0.0]
    return np.concatenate([nodes[:1], inner[nodes[-1] - inner > least], nodes[-1:]])


def even_in_time(t: Floats, ends: tuple[float, float], step: float) -> Floats:
    """(n - 1,) nodes between the times t (n,): one every `step`, but no coarser than GRADING next to rest."""
    total, middle = t[-1], (t[1:] + t[:-1]) / 2.0
    density = np.full(len(middle), 1.0 / step)
    for distance, z in ((middle, ends[0]), (total - middle, ends[1])):
        if z == 0.0:
            density = np.maximum(density, 1.0 / (GRADING * np.maximum(distance, step)))
    count: Floats = np.diff(t) * density
    return count


def steps_a_cell(run: AxisRun, limits: Limits, rough: Guess) -> Floats:
    """(n - 1,) how many steps a cell may be long: more the further away it is in time from all places that are not at
    a cap."""
    ramp = RAMPS_FINE * ramp_time(limits)
    middle = (rough.t[1:] + rough.t[:-1]) / 2.0
    if not ramp < rough.t[-1]:
        return np.ones(len(middle))
    others = np.concatenate([[-np.inf], rough.t[~at_caps(run, limits, rough)], [np.inf]])
    after = np.searchsorted(others, middle)
    away = np.minimum(middle - others[after - 1], others[after] - middle)
    steps: Floats = np.clip(away / ramp, 1.0, COARSEST)
    return steps


def where_z_bends(rough: Guess) -> Floats:
    """(n - 1,) nodes between which z is straight but for STRAIGHT: a cap that turns is followed by many cells."""
    slope = np.diff(rough.z) / np.diff(rough.s)
    bend = np.abs(np.pad(2.0 * np.diff(slope) / (rough.s[2:] - rough.s[:-2]), 1))
    z = np.maximum(np.minimum(rough.z[1:], rough.z[:-1]), NEXT_TO_REST * rough.z.max())
    count: Floats = np.diff(rough.s) * np.sqrt(np.maximum(bend[1:], bend[:-1]) / (8.0 * STRAIGHT * z))
    return count


def at_caps(run: AxisRun, limits: Limits, rough: Guess) -> Bools:
    """(n,) where the guess is at its cap by feed and velocity, on both sides of a break, and needs little acceleration
    and jerk there."""
    of_joints = limits.velocity, frozen(IN_USE * limits.acceleration), frozen(IN_USE * limits.jerk)

    def at_cap(s: Floats, z: Floats) -> Bools:
        path, feed = run.with_cap(s)
        cap, steady, _ = first_guess.pointwise(np.ascontiguousarray(path), *of_joints, feed)
        return np.asarray((z >= (1.0 - AT_CAP) * cap) & (z <= steady * (1.0 + AT_CAP)))

    parts = [slice(first, first + CHUNK) for first in range(0, len(rough.s), CHUNK)]
    found = np.concatenate([at_cap(rough.s[part], rough.z[part]) for part in parts])
    broken = np.flatnonzero(np.isin(rough.s, run.breaks))
    found[broken] &= at_cap(np.nextafter(rough.s[broken], -np.inf), rough.z[broken])
    return found


def finer_where_z_falls(count: Floats, rough: Guess, ends: tuple[float, float], step: float) -> Floats:
    """(n - 1,) the same, with NODES_A_FALL at least while z changes by the factor e; next to rest it always does."""
    total, middle = rough.t[-1], (rough.t[1:] + rough.t[:-1]) / 2.0
    moves = (middle > (step if ends[0] == 0.0 else 0.0)) & (middle < total - (step if ends[1] == 0.0 else 0.0))
    fall = np.abs(np.diff(np.log(np.maximum(rough.z, 1e-300))))
    return np.where(moves, np.maximum(count, NODES_A_FALL * fall), count)


def needed_hints(run: AxisRun, limits: Limits, rough: Guess) -> Floats:
    """(h,) the hints of a run without those between which its path tells all at the guess's speed; breaks stay.

    Of three in a row the middle one goes, where the outer two tell the path; and so on with what is left.
    """
    s = np.unique(np.concatenate([[run.s0], run.hints, run.breaks, [run.s1]]))
    s = s[(s >= run.s0) & (s <= run.s1)]
    path, z, stays = run.evaluate(s), np.interp(s, rough.s, rough.z), np.isin(s, run.breaks)
    while len(s) > 2:
        middle = np.arange(1, len(s) - 1, 2)
        middle = middle[~stays[middle]]
        low, high = np.ascontiguousarray(path[:, middle - 1]), np.ascontiguousarray(path[:, middle + 1])
        fastest = np.maximum(np.maximum(z[middle - 1], z[middle + 1]), z[middle])
        of_joints = limits.velocity, limits.acceleration, limits.jerk
        unseen = first_guess.unseen(low, high, s[middle + 1] - s[middle - 1], fastest, *of_joints)
        left = np.ones(len(s), dtype=np.bool_)
        left[middle[unseen <= SMOOTH]] = False
        if left.all():
            break
        s, path, z, stays = s[left], path[:, left], z[left], stays[left]
    return s[1:-1]


def between_hints(run: AxisRun, hints: Floats, rough: Guess, step: float) -> Floats:
    """(n - 1,) nodes for CELLS_A_HINT between hints: the third derivative bends there, unless they are one place."""
    hints = np.unique(np.concatenate([[run.s0], hints, [run.s1]]))
    middle = (rough.s[1:] + rough.s[:-1]) / 2.0
    inside = np.clip(np.searchsorted(hints, middle) - 1, 0, len(hints) - 2)
    share = np.diff(rough.s) / np.diff(hints)[inside]
    return np.minimum(CELLS_A_HINT * share, np.diff(rough.t) / (ONE_PLACE * step))


def spread_nodes(
    run: AxisRun, rough: Guess, measure: Floats, wanted: int, ends: tuple[float, float], step: float
) -> Floats:
    """The nodes that are wanted, even in a measure (n,) that grows along the guess; next to rest one step is one."""
    total, length = rough.t[-1], run.s1 - run.s0
    outer = [step if z == 0.0 else 0.0 for z in ends]
    first, last = np.interp([outer[0], total - outer[1]], rough.t, measure)
    inner = wanted - sum(z == 0.0 for z in ends)
    graded = to_graded((rough.s - run.s0) / length, ends)
    nodes = run.s0 + length * from_graded(np.interp(np.linspace(first, last, inner + 1), measure, graded), ends)
    nodes = np.concatenate([[run.s0] if ends[0] == 0.0 else [], nodes, [run.s1] if ends[1] == 0.0 else []])
    nodes[0], nodes[-1] = run.s0, run.s1
    return nodes


def with_breaks(nodes: Floats, breaks: Floats, one_place: float = ONE_PLACE) -> Floats:
    """The same nodes with the breaks among them, the nearest node moved where it lies within a third of a cell.

    Breaks closer together than the share `one_place` of the cells there become one node.
    """
    cell = np.diff(nodes)
    least = one_place * cell[np.clip(np.searchsorted(nodes, breaks) - 1, 0, len(cell) - 1)]
    least = np.maximum(least, shortest_cell(nodes))
    inside = (breaks > nodes[0] + least) & (breaks < nodes[-1] - least)
    breaks = breaks[inside & (np.diff(breaks, prepend=-np.inf) > least)]
    if len(breaks) == 0:
        return nodes
    inner = nodes[1:-1]
    k = np.clip(np.searchsorted(breaks, inner), 1, len(breaks)) - 1
    near = np.minimum(np.abs(inner - breaks[k]), np.abs(inner - breaks[np.minimum(k + 1, len(breaks) - 1)]))
    keep = near > 0.34 * np.minimum(cell[:-1], cell[1:])
    return np.unique(np.concatenate([nodes[:1], inner[keep], breaks, nodes[-1:]]))


def graded(nodes: Floats) -> Floats:
    """The nodes with cells halved that are much longer than their neighbours: there a spline swings."""
    while True:
        cell = np.diff(nodes)
        beside = np.minimum(np.append(cell[1:], np.inf), np.insert(cell[:-1], 0, np.inf))
        long = cell > MOST_UNLIKE * beside
        if not long.any():
            return nodes
        nodes = cut_cells(nodes, np.where(long, 2, 1))


def cut_cells(nodes: Floats, parts: Ints) -> Floats:
    """The nodes with each cell cut into `parts` (n - 1,) equal cells."""
    cell = np.repeat(np.arange(len(parts)), parts)
    first = np.concatenate([[0], np.cumsum(parts)[:-1]])
    share = (np.arange(len(cell)) - first[cell]) / parts[cell]
    return np.append(nodes[cell] + share * np.diff(nodes)[cell], nodes[-1])
