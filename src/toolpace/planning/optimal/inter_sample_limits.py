"""Limits between the nodes of a mesh: held by added rows and finer cells, then by slow-down in place."""

from __future__ import annotations

import contextlib

import numpy as np

from toolpace.common.arrays import Bools, Floats, Ints
from toolpace.common.workers import UNTOLD, Progress, Workers
from toolpace.motion.laws import SplineLaw
from toolpace.planning.limit_tolerances import ALLOWED, GUARANTEE
from toolpace.planning.optimal.meshed_run import MeshedRun, too_short, without_undershoot
from toolpace.planning.optimal.slow_down import SlowDown, closer, slowed_in_place, slowing_factor, worth
from toolpace.planning.optimal.solve import LIMITS, Stalled, slower
from toolpace.planning.optimal.windows import mend, solve_run, stretches
from toolpace.planning.peaks import LimitCheck, Peaks, largest

START_LOSS = 0.03
"""Share of z by which a solve that starts from a solution is slowed down first."""
WARM_SPREAD = 0.1
"""First gap of such a solve, relative to the duration."""
MOST_PASSED = 1.5
"""Usage beyond which a start is slowed down no further."""
REFINE_ROUNDS = 6
"""Rounds in which cells are cut, lest the mesh grow without end."""
LEAST_CELL = 1e-5
"""Time of a cell, as a share of that in which an acceleration builds up, below which it is cut no further."""
REFINE_ABOVE, QUARTER_ABOVE = 1.01, 1.05
"""Usage between nodes from which a cell is cut in two, or in four: too long for the path or the motion in it."""
ASTRAY = 1.2
"""How much longer than with its limits at the nodes a law may take once no more cells are cut: beyond it, more rounds
take long and end little better; another mesh does."""
MOST_ROUNDS = 20
"""Rounds after which the best law so far is slowed down."""
PATIENCE = 3
"""Rounds after which limits are lowered by more than usual, and at nodes too."""
EASED_BY = 1e-4
"""Share of the duration that easing may cost: less is not worth another round."""
URGE, MOST_URGE = 1.3, 6.0
"""By how much more after each further round, and at most."""
MOST_MENDED = 0.8
"""Share of the nodes beyond which mending is no cheaper than solving anew."""
GIVE = 1e-5
"""Share by which limits are raised in a stretch that is mended: between ends that are at their limits already there may
be no other motion within the same ones."""
IDLE = 0.5
"""Share of a limit below which it is not held about a place in another solve: what comes to use more then, the next
look sees."""
TOO_SLOW = 0.9
"""Share of z at the limits from which a motion that uses none of them is sped up as a whole."""


def held_between_nodes(
    meshed: MeshedRun, law: SplineLaw, fixed: bool, workers: Workers, progress: Progress = UNTOLD,
    most_rounds: int = MOST_ROUNDS,
) -> SplineLaw:  # fmt: skip
    """The law with its limits held between the nodes too. Raises Stalled where that cannot be had.

    repeat
      look between the nodes:  (nearly) nothing passed?  ease it, done
      cut the cells that pass a limit by far (unless the mesh is fixed);  put rows where the others pass one
      solve again around them;  keep the law that will be the fastest once it is slowed down to the guarantee
    slow the best one down to the guarantee: after so many rounds, or where the cells that were cut led astray, or the
    rounds did, and came to a law that is slower than that
    """
    best: tuple[MeshedRun, SplineLaw, Floats] | None = None
    least, at_nodes = np.inf, law.duration
    for number in range(most_rounds + 1):
        peaks, now, slow = checked_between_nodes(meshed, law, number, workers)
        dips = law.dips()
        if not dips.any() and now <= (1.0 + EASED_BY) * law.duration:
            gently = slowed_in_place(meshed.look, law, peaks.used, meshed.ramp, workers, slow)
            if gently is not None:
                if best is None or gently.duration <= (1.0 + EASED_BY) * least:
                    return gently
                return at_least_as_fast(gently, *best, workers)
            slow = None
        if best is None or now < least:
            best, least = (meshed, law, peaks.used), now
        if number == most_rounds or (number == REFINE_ROUNDS and not fixed and least > ASTRAY * at_nodes):
            break
        parts = parts_of_cells(meshed, law, peaks, dips, fixed or number >= REFINE_ROUNDS)
        dear = largest(peaks.used) > ALLOWED if slow is None else slow.dear(EASED_BY / 2.0 * law.duration)
        if parts.max() == 1 and not dear.any():
            break  # z falls in cells too short to be cut: another solve would find the same
        anew = dear | dips | (parts > 1)
        meshed, c = cut_and_held(meshed, law, peaks, parts, dips, number)
        # how many rounds there will be nobody knows; the first ones take the longest
        halfway = progress.part(1.0 - 0.5**number, 1.0 - 0.5 ** (number + 1))
        try:
            c = resolve(meshed, c, np.repeat(anew, parts), float(peaks.used.max()), workers, halfway)
        except Stalled:
            break
        law = SplineLaw(meshed.nodes, c, meshed.rest)
    assert best is not None
    return within_guarantee(*best, workers)


def without_falls(meshed: MeshedRun, law: SplineLaw, workers: Workers) -> SplineLaw:
    """The law with its limits at the nodes, on finer cells where z falls far between two. Raises Stalled.

    Where a path turns back on its own way z may come to next to nothing there, and the duration tells nothing.
    """
    for _ in range(REFINE_ROUNDS):
        falls = law.dips()
        parts = np.where(falls & ~too_short(law.nodes), 4, 1)
        if parts.max() == 1:
            break
        meshed, c = meshed.cut(law, parts)
        cells = len(meshed.nodes) - 1
        wrong = np.repeat(falls, parts)
        meshed.hold(Peaks(np.ones((cells, 3)), np.zeros((cells, 3))), wrong, np.zeros(cells, dtype=np.bool_), 1.0)
        law = SplineLaw(meshed.nodes, resolve(meshed, c, wrong, 1.0, workers), meshed.rest)
    return law


def at_least_as_fast(held: SplineLaw, meshed: MeshedRun, law: SplineLaw, used: Floats, workers: Workers) -> SplineLaw:
    """A law that is held, or that of an earlier round slowed down to the guarantee, whichever is faster."""
    with contextlib.suppress(Stalled):
        return min(held, within_guarantee(meshed, law, used, workers), key=lambda one: one.duration)
    return held


def checked_between_nodes(
    meshed: MeshedRun, law: SplineLaw, number: int, workers: Workers
) -> tuple[Peaks, float, SlowDown | None]:
    """The peaks of a law, about how long it takes once it is slowed down for the guarantee [s], and how if in place.

    One that is good enough to be the last is worth a closer look. Cells are cut in the first rounds only: nothing may
    hide from them.
    """
    peaks = meshed.look.peaks(law, workers)
    now, slow = worth(meshed.look, law, peaks.used, meshed.ramp)
    if now <= (1.0 + EASED_BY) * law.duration:
        closer = meshed.look.confirmed(law, peaks, workers)
    elif number < REFINE_ROUNDS:
        closer = meshed.look.with_hidden(law, peaks)
    else:
        closer = peaks
    if closer is not peaks:
        now, slow = worth(meshed.look, law, closer.used, meshed.ramp)
    return closer, now, slow


def parts_of_cells(meshed: MeshedRun, law: SplineLaw, peaks: Peaks, dips: Bools, kept: bool) -> Ints:
    """(cells,) in how many parts each cell is cut; where the mesh is `kept`, only those in which z falls too far."""
    parts = np.where(dips, 4, 1 if kept else halves(peaks.used))
    parts[(np.diff(law.times) < meshed.ramp * LEAST_CELL) | too_short(law.nodes)] = 1
    return parts


def cut_and_held(
    meshed: MeshedRun, law: SplineLaw, peaks: Peaks, parts: Ints, dips: Bools, number: int
) -> tuple[MeshedRun, Floats]:
    """The run with its cells cut in so many parts (cells,), and rows where those pass a limit that are not.

    Returns with it the coefficients of the same law.
    """
    meshed, c = meshed.cut(law, parts)
    wrong = np.repeat((largest(peaks.used) > ALLOWED) | dips, parts)
    used = np.repeat(np.where(parts[:, None] > 1, 1.0, peaks.used), parts, axis=0)
    fresh = np.repeat(parts > 1, parts)
    urge = min(URGE ** max(number - PATIENCE, 0), MOST_URGE)
    meshed.hold(Peaks(used, np.repeat(peaks.place, parts, axis=0)), wrong, fresh, urge)
    return meshed, c


def halves(used: Floats) -> Ints:
    """Parts into which the cells of these peaks (cells, 3) are cut."""
    worst = largest(used)
    return np.where(worst > QUARTER_ABOVE, 4, np.where(worst > REFINE_ABOVE, 2, 1))


def resolve(
    meshed: MeshedRun, c: Floats, wrong: Bools, used: float, workers: Workers, progress: Progress = UNTOLD
) -> Floats:
    """New coefficients after the rows or the mesh at the marked cells changed, because c `used` so much of a limit.

    Only stretches around those cells are solved again, unless they are most of the run.
    """
    loss = START_LOSS + 1.0 - 1.0 / min(used, MOST_PASSED)
    idle = IDLE * (1.0 - loss) ** 1.5  # what the slower start uses where the law uses so much of a jerk
    parts = stretches(meshed, wrong)
    if sum(part.high - part.low for part in parts) < MOST_MENDED * len(wrong):
        mended, stuck = mend(meshed, c, parts, loss, WARM_SPREAD, workers, progress, give=GIVE, idle=idle)
        if not stuck:
            return mended
    return solve_run(meshed, slower(meshed, c, loss), WARM_SPREAD, workers, progress, idle)


def within_guarantee(meshed: MeshedRun, law: SplineLaw, peak: Floats, workers: Workers) -> SplineLaw:
    """The law, with its peaks (cells, 3), within the guarantee: slowed down about the places that pass it.

    That is done so gently that nothing else passes. Where that does not do, or is no better, it is slowed down as a
    whole; with an end in motion it cannot be: Stalled. One that could not be solved, and so uses no limit anywhere, is
    sped up.
    """
    look = meshed.look
    if law.dips().any():
        law = without_undershoot(law)
        look = LimitCheck(meshed.run, meshed.limits, law.nodes)
        peak = look.peaks(law, workers).used
    # the best of many rounds may not have been looked at closely
    peak = np.maximum(peak, look.confirmed(law, look.peaks(law, workers), workers).used)
    rests = law.rest[0] > 0.0 and law.rest[1] > 0.0
    if peak.max() <= GUARANTEE:
        unused = rests and 0.0 < slowing_factor(peak) < TOO_SLOW
        return law.slowed(closer(look, law, peak, workers)) if unused else law
    finite = bool(np.isfinite(peak).all())
    slowed = law.slowed(max(1.0, closer(look, law, peak, workers))) if finite and rests else None
    gently = slowed_in_place(look, law, peak, meshed.ramp, workers) if finite else None
    if gently is not None and (slowed is None or gently.duration < slowed.duration):
        return gently
    if slowed is None:
        cell, kind = divmod(int(np.nan_to_num(peak, nan=np.inf).argmax()), peak.shape[1])
        raise Stalled(float(law.nodes[cell]), LIMITS[kind])
    return slowed
