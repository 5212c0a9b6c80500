"""Motions that keep the continuous ratings of motors: the root mean square of a torque over a window of time.

The mean square is no row of the planner's problem. Two things lower it: a motion that takes less of a motor beyond what
weight and friction take, and one that takes more time for all.

    the fastest motion; where it keeps all ratings, it is the answer
    repeat    this motion, all of it slower by one factor, until it keeps all ratings: a candidate
              of each motor above its rating, or eased by more than it must be:
                  the share of what weight and friction leave, by the secant of the mean square beyond these
              the fastest motion within these shares                                  (JointTorque.eased: a row each)
    until     each motor that is eased uses its rating nearly, or a candidate is no faster
    the fastest candidate

Of any motion that keeps the ratings the bound of the first motion is true as well. What is found is not the optimum:
that would ease a torque more or less along the way (docs/design/torques.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from toolpace.common.errors import InfeasibleError, UsageError
from toolpace.machine.dynamics.torques import ContinuousRating, JointTorque
from toolpace.machine.limits import CONTINUOUS, Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.torques_over_time import TorquesOverTime, continuous_shares, rated_torques
from toolpace.motion.trajectory import Trajectory

KEPT, ENOUGH = 0.9995, 0.997
"""Shares of a rating that a motion may use, and from which a motor need not be eased less."""
AIM = 0.9985
MOST_PLANS = 12
IN_VAIN = 1
"""Motions that bring no faster candidate after which the fastest is taken."""
EXPONENTS = (0.5, 3.0)
"""Of the mean square beyond weight and friction over the share: the least and the largest that is reckoned with."""
STEP = 6.0
"""Most by which a share changes from one plan to the next."""
SLOWEST, HALVINGS = 100.0, 40
"""Largest factor by which a motion is slowed down, and how often the interval of it is halved."""


@dataclass
class Easing:
    """The share of one motor, and what was seen of it."""

    rows: JointTorque
    rating: ContinuousRating
    share: float = 1.0
    exponent: float = 2.0
    used: float = 0.0
    """Of the rating by the last motion."""
    held: float = 0.0
    """The same by what weight and dry friction take of it."""

    @property
    def settled(self) -> bool:
        """Whether the rating is kept, and the motor eased no more than it must be."""
        return self.used <= KEPT and (self.share == 1.0 or self.used >= ENOUGH)

    @property
    def beyond(self) -> float:
        """The mean square beyond weight and friction."""
        return max(self.used**2 - self.held**2, 1e-9)

    def take(self, used: float, held: float, before: float) -> None:
        """Note what a motion uses of the rating, planned with another share than the one before it."""
        first, former = self.used == 0.0, self.beyond
        self.used, self.held = used, held
        change = math.log(self.share / before)
        if not first and abs(change) > 1e-4:
            self.exponent = min(max(math.log(self.beyond / former) / change, EXPONENTS[0]), EXPONENTS[1])

    def next_share(self) -> float:
        """The share to try."""
        if self.settled:
            return self.share
        wanted = max(AIM**2 - self.held**2, 0.0) / self.beyond
        change = float(wanted ** (1.0 / self.exponent))
        return min(self.share * min(max(change, 1.0 / STEP), STEP), 1.0)


def within_ratings(first: Trajectory, planned: Callable[[Limits], Trajectory]) -> Trajectory:
    """A motion that keeps the continuous ratings, from the fastest one, and a function that plans within limits.

    Raises InfeasibleError where none is found.
    """
    rated = rated_torques(first.limits)
    if not rated:
        return first
    motors = [Easing(rows, rows.rating) for rows in rated if rows.rating is not None]
    best: Trajectory | None = None
    found, before, in_vain = first, [1.0] * len(motors), 0
    for tried in range(MOST_PLANS):
        torques = TorquesOverTime.of(found.axis_path, found.laws, rated)
        at_pace, at_rest = shares(torques, motors), shares(torques, motors, math.inf)
        for motor, *seen in zip(motors, at_pace, at_rest, before):
            motor.take(*seen)
        if tried == 0 and all(motor.used <= KEPT for motor in motors):
            return first
        candidate = slowed_down(found, slowest_needed(torques, motors))
        if candidate is not None and (best is None or candidate.duration < best.duration):
            best, in_vain = candidate, 0
        else:
            in_vain += 1
        if all(motor.settled for motor in motors) or in_vain >= IN_VAIN:
            break
        before = [motor.share for motor in motors]
        for motor in motors:
            motor.share = motor.next_share()
        found = planned(eased_limits(first.limits, motors))
    if best is None:
        raise InfeasibleError(not_kept(max(motors, key=lambda motor: motor.used)))
    used = continuous_shares(best.axis_path, best.limits, best.laws)
    names = ", ".join(name for name, each in used.items() if each >= ENOUGH)
    note = f"slowed for {names}: not the fastest that keeps it; the bound is of motions that need not"
    return replace(
        best, lower_bound=first.lower_bound, notes=(*best.notes, note), solve_seconds=found.solve_seconds,
        open_places=(), pricing=no_prices,
    )  # fmt: skip


def shares(torques: TorquesOverTime, motors: list[Easing], slower: float = 1.0) -> list[float]:
    """What the motors use of their ratings where all moves take so many times as long; inf: at rest along the way."""
    length, values = torques.slowed(1.0 if math.isinf(slower) else slower)
    if math.isinf(slower):
        values = torques.parts[2]
    return [motor.rating.share(length, value) for motor, value in zip(motors, values)]


def slowest_needed(torques: TorquesOverTime, motors: list[Easing]) -> float:
    """The factor of time, 1 or more, by which a motion keeps all ratings, to the next number above; inf where none."""
    if max(shares(torques, motors)) <= KEPT:
        return 1.0
    low, high = 1.0, 1.05
    while max(shares(torques, motors, high)) > KEPT:
        low, high = high, high * high
        if high > SLOWEST:
            return math.inf
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        if max(shares(torques, motors, middle)) <= KEPT:
            high = middle
        else:
            low = middle
    return high


def slowed_down(found: Trajectory, factor: float) -> Trajectory | None:
    """The motion with all moves slower by a factor; None where it cannot be."""
    if factor == 1.0:
        return found
    laws = [law for law in found.laws if isinstance(law, SplineLaw) and min(law.rest) > 0.0]
    if math.isinf(factor) or len(laws) < len(found.laws):
        return None
    return replace(found, laws=tuple(law.slowed(factor**2) for law in laws))


def eased_limits(limits: Limits, motors: list[Easing]) -> Limits:
    """The limits with a row for each motor that is eased."""
    return replace(limits, rows=(*limits.rows, *(m.rows.eased(m.share) for m in motors if m.share < 1.0)))


def unrated(limits: Limits) -> Limits:
    """The limits without continuous ratings, the torques as they are."""
    rows = [replace(rows, rating=None) if isinstance(rows, JointTorque) else rows for rows in limits.rows]
    return replace(limits, rows=tuple(rows))


def not_kept(motor: Easing) -> str:
    """That a rating is kept by no motion that was found, in a message."""
    rows, rating = motor.rows, motor.rating
    window = f" over {rating.window:g} s" if math.isfinite(rating.window) else ""
    return (
        f"{CONTINUOUS}{rows.name}: no motion found that keeps {rating.torque:.6g} {rows.unit} in the root mean "
        f"square{window}; the slowest takes {motor.used * rating.torque:.6g}, weight and friction alone "
        f"{motor.held * rating.torque:.6g} of it; give a stronger motor, a weight balance, or a longer window"
    )


def no_prices(trajectory: Trajectory) -> dict[str, float]:
    """Raise UsageError: of a mean square there are no multipliers."""
    raise UsageError("prices: the motion was slowed for a continuous rating, which has none; plan without it")
