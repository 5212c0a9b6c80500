"""toppra: reachability analysis for velocity and acceleration; it knows no jerk. Even mesh of n cells."""

from __future__ import annotations

import logging

import numpy as np
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
from toppra.interpolator import AbstractGeometricPath

from benchmarks.peers import Outcome, Stopwatch, failed, usage
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun

logging.getLogger("toppra").setLevel(logging.CRITICAL)
UNLIMITED = 1e6


class RunPath(AbstractGeometricPath):
    """The run's own callable, as toppra wants it."""

    def __init__(self, run: AxisRun, joints: int) -> None:
        self.run, self.joints = run, joints

    def __call__(self, path_positions: np.ndarray, order: int = 0) -> np.ndarray:
        return np.ascontiguousarray(self.run.f(path_positions, order))

    @property
    def dof(self) -> int:
        """Number of joints."""
        return self.joints

    @property
    def path_interval(self) -> np.ndarray:
        """First and last parameter."""
        return np.array([self.run.s0, self.run.s1])


class FeedConstraint(JointVelocityConstraint):
    """Joint velocities, and the cap on ds/dt."""

    def __init__(self, velocity: np.ndarray, run: AxisRun) -> None:
        super().__init__(velocity)
        self.run = run

    def compute_constraint_params(self, path: AbstractGeometricPath, gridpoints: np.ndarray) -> tuple:
        *rest, bound = super().compute_constraint_params(path, gridpoints)
        bound[:, 1] = np.minimum(bound[:, 1], self.run.speed_cap(gridpoints) ** 2)
        return *rest, bound


def solve(axis_path: AxisPath, limits: Limits, n: int, *, judge: bool = True) -> Outcome:
    """Its own pass over n cells, joint limits imposed at both ends of each (its default)."""
    run = axis_path.runs[0]
    watch = Stopwatch()
    grid = np.linspace(run.s0, run.s1, n + 1)
    path = RunPath(run, len(limits))
    constraints = [
        FeedConstraint(np.minimum(limits.velocity, UNLIMITED), run),
        JointAccelerationConstraint(limits.acceleration),
    ]
    algorithm = TOPPRA(
        constraints, path, gridpoints=grid, solver_wrapper="seidel", parametrizer="ParametrizeConstAccel"
    )
    acceleration, speed, _ = algorithm.compute_parameterization(0.0, 0.0)
    seconds = watch()
    if speed is None:
        return failed(seconds, "no parameterisation")
    duration = float((2.0 * np.diff(grid) / (speed[1:] + speed[:-1])).sum())
    if not judge:
        return Outcome(duration, seconds, points=n + 1)

    def state(cell: np.ndarray, x: np.ndarray, s: np.ndarray) -> np.ndarray:
        z = speed[cell] ** 2 * (1.0 - x) + speed[cell + 1] ** 2 * x
        return np.stack([s, np.sqrt(z), acceleration[cell], np.zeros(len(s))])

    free = Limits(limits.velocity, limits.acceleration, np.inf, limits.joints)
    at_nodes, between = usage(run, free, grid, state)
    return Outcome(
        duration, seconds, at_nodes, between, note=f"jerk x {jerk(run, limits, grid, speed):.0f}", points=n + 1
    )


def jerk(run: AxisRun, limits: Limits, grid: np.ndarray, speed: np.ndarray) -> float:
    """Largest jerk over its limit, by differences of the joints' velocities at 1 ms."""
    times = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(grid) / (speed[1:] + speed[:-1]))])
    t = np.arange(0.0, times[-1], 1e-3)
    k = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(grid) - 2)
    tau = t - times[k]
    rate = (speed[k + 1] - speed[k]) / (times[k + 1] - times[k])
    s = grid[k] + speed[k] * tau + rate * tau**2 / 2.0
    velocity = run.evaluate(s)[1] * (speed[k] + rate * tau)[:, None]
    return float((np.abs(np.diff(velocity, 2, axis=0)) / 1e-6 / limits.jerk).max())
