"""Root mean square of motors' torques over a motion, against their continuous ratings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Bools, Floats
from toolpace.machine.dynamics.torques import JointTorque
from toolpace.machine.limits import CONTINUOUS, Limits
from toolpace.motion.active_limits import BINDING, NOTHING
from toolpace.motion.laws import TimeLaw
from toolpace.path.axis_path import AxisPath


@dataclass(frozen=True)
class TorquesOverTime:
    """Torques of k motors at n states of a motion, dwells with them."""

    length: Floats
    """(n,) time that each state stands for [s]."""
    moves: Bools
    """(n,) whether the joints move; they wait in a dwell."""
    parts: Floats
    """(3, k, n) of each torque [N m, N]: what falls with the square of the speed, with the speed, and not at all."""

    @classmethod
    def of(cls, path: AxisPath, laws: Sequence[TimeLaw], motors: Sequence[JointTorque]) -> TorquesOverTime:
        """Those of a motion, at the states at which its laws are probed."""
        runs, lengths, moves, parts = path.runs, [], [], []

        def take(length: Floats, q: Floats, state: Floats, *, moving: bool = True) -> None:
            lengths.append(length)
            moves.append(np.full(len(length), moving))
            parts.append(np.stack([motor.parts(q, state) for motor in motors], axis=1))

        def wait(time: float, run: int, s: float) -> None:
            if time > 0.0:
                q = runs[run].evaluate(np.array([s]))
                q[1:] = 0.0
                take(np.array([time]), q, np.zeros((4, 1)), moving=False)

        wait(path.first_dwell, 0, runs[0].s0)
        for k, (run, law) in enumerate(zip(runs, laws)):
            for probe in law.probes():
                q = run.evaluate(np.clip(probe.state[0], run.s0, run.s1))
                take(np.asarray(probe.share), np.ascontiguousarray(q), probe.state)
            wait(run.dwell, k, run.s1)
        return cls(np.concatenate(lengths), np.concatenate(moves), np.concatenate(parts, axis=2))

    def slowed(self, by: float) -> tuple[Floats, Floats]:
        """(n,) times and (k, n) torques of the same motion, its moves taking so many times as long."""
        square, linear, constant = self.parts
        return self.length * np.where(self.moves, by, 1.0), square / by**2 + linear / by + constant


def rated_torques(limits: Limits) -> list[JointTorque]:
    """The torques that have a continuous rating."""
    return [rows for rows in limits.rows if isinstance(rows, JointTorque) and rows.rating is not None]


def with_ratings(times: dict[str, float], shares: dict[str, float]) -> dict[str, float]:
    """The time in which each limit binds [s], with the rating that is used most in place of "nothing" where it binds.

    A mean square is of all of a motion: what no other limit holds, it does.
    """
    most = max(shares, key=lambda name: shares[name], default="")
    if not most or shares[most] < BINDING:
        return dict(times)
    found = {name: time for name, time in times.items() if name != NOTHING}
    return found | {most: found.get(most, 0.0) + times.get(NOTHING, 0.0)}


def continuous_shares(path: AxisPath, limits: Limits, laws: Sequence[TimeLaw]) -> dict[str, float]:
    """The largest root mean square over a thermal window, over the rating, by name: "continuous torque A".

    Dwells count with the torque that holds the joints. Empty where nothing is rated.
    """
    rated = rated_torques(limits)
    if not rated:
        return {}
    length, torques = TorquesOverTime.of(path, laws, rated).slowed(1.0)
    return {
        CONTINUOUS + rows.name: rows.rating.share(length, torque)
        for rows, torque in zip(rated, torques)
        if rows.rating is not None
    }
