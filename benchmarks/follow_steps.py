"""How long a step of the follower's kernel takes, and one of ruckig's on the same correction."""

from __future__ import annotations

import ctypes
import time

import numba
import numpy as np

from benchmarks.tables import Table
from toolpace.common.arrays import Floats, Ints
from toolpace.deflection.following import Follower
from toolpace.kernels.follow import layout as at
from toolpace.kernels.follow.correction import correct
from toolpace.kernels.follow.correction_target import chain_of
from toolpace.kernels.follow.pace import place_on_path
from toolpace.kernels.follow.step import step
from toolpace.kernels.kinematics.chain import forward
from toolpace.machine.machine import Machine
from toolpace.path.path import Path
from toolpace.planning.planner import plan

STEPS = 1_000_000
REPEATS = 3
"""Runs of the same steps: what other processes on the machine cost differs from run to run, what a step does not."""
WALL, OF_THREAD = 1, 3
"""Clocks of Linux: CLOCK_MONOTONIC, CLOCK_THREAD_CPUTIME_ID."""
READ = ctypes.CDLL(None).clock_gettime
READ.argtypes = [ctypes.c_int, ctypes.c_void_p]
TAU, NOW, DURATION, INPUTS, STATE, OVERRIDE, AIM = (
    at.TAU, at.NOW, at.DURATION, at.INPUTS, at.STATE, at.OVERRIDE, at.AIM,
)  # fmt: skip


def circling(turns: float) -> Path:
    """Turns round a circle of 10 mm at 50 mm/s, the tool leaning outwards by 0.3."""

    def f(s: Floats, order: int) -> tuple[Floats, Floats]:
        angle, rate = 2.0 * np.pi * turns * s + 0.5 * np.pi * order, (2.0 * np.pi * turns) ** order
        x, y = rate * np.cos(angle), rate * np.sin(angle)
        zero = np.zeros_like(s)
        up = np.full_like(s, np.cos(0.3)) if order == 0 else zero
        return 0.01 * np.stack([x, y, zero], axis=1), np.stack([np.sin(0.3) * x, np.sin(0.3) * y, up], axis=1)

    return Path.from_callable(f, feed=0.05)


def kernel_times(steps: int = STEPS) -> Table:
    """A million steps with noise, a trembling override and holds, on short and long paths, by both clocks."""
    table = Table(
        f"Time of a step of the kernel [us], {steps} steps: a measurement each, another override every 150",
        ["set-points of the path", "clock", "median", "99 %", "99.9 %", "99.99 %", "most"],
        words=2,
    )
    machine = Machine.load("paper-ab")
    for turns in (0.25, 26.5):
        trajectory = plan(circling(turns), machine.reserved(0.1), bound=False)
        follower = Follower(trajectory, machine, delay=4e-3)
        of_thread = [times_of(follower, steps, OF_THREAD) for _ in range(REPEATS)]
        rows = {
            "thread, one run": of_thread[0],
            f"thread, each step's least of {REPEATS}": np.min(of_thread, axis=0),
            "wall, one run": times_of(follower, steps, WALL),
        }
        for name, times in rows.items():
            spent = 1e-3 * np.sort(times)
            shares = (0.5, 0.99, 0.999, 0.9999)
            row = [f"{spent[int(share * steps)]:.2f}" for share in shares]
            table.lines.append([f"{int(follower.duration / follower.period)}", name, *row, f"{spent[-1]:.1f}"])
    return table


def times_of(follower: Follower, steps: int, clock: int) -> Ints:
    """(steps,) time of each step [ns]."""
    random = np.random.default_rng(0)
    override = np.repeat(random.choice([0.0, 0.3, 0.7, 1.0, 1.1, 1.2], 2000), 150)
    noise = 50e-6 * random.normal(size=(100_003, 3))
    buffer, spent = np.zeros(2, dtype=np.int64), np.zeros(steps, dtype=np.int64)
    follower.reset()
    out = np.empty(at.OUTPUTS)
    for times in (spent[:1000], spent):
        _timed(follower.piece, follower.state, override, noise, out, clock, buffer, buffer.ctypes.data, times)
    return spent


@numba.njit(error_model="numpy")
def _timed(
    piece: Floats, state: Floats, override: Floats, noise: Floats, out: Floats, clock: int, buffer: Ints,
    address: int, times: Ints,
) -> None:  # fmt: skip
    chain, given, column = chain_of(piece), np.full(INPUTS, np.nan), np.empty(4)
    q, tip, axis = np.empty(5), np.empty(3), np.empty(3)
    for i in range(len(times)):
        if state[TAU] >= piece[DURATION]:
            state[:] = 0.0
        for j in range(5):
            place_on_path(piece, state[TAU], j, column)
            q[j] = column[0]
        forward(chain, q.reshape((1, 5)), tip.reshape((1, 3)), axis.reshape((1, 3)))
        given[0] = state[NOW]
        for d in range(3):
            given[1 + d] = tip[d] + noise[i % len(noise), d]
        given[OVERRIDE] = override[i % len(override)]
        READ(clock, address)
        before = buffer[0] * 1_000_000_000 + buffer[1]
        step(piece, state, given, out)
        READ(clock, address)
        times[i] = buffer[0] * 1_000_000_000 + buffer[1] - before


def ruckig_times(steps: int = 20_000) -> Table:
    """Five joints to aims that noise moves: our tracker, and ruckig's own word on each calculation."""
    import ruckig

    machine = Machine.load("paper-ab")
    follower = Follower(plan(circling(0.7), machine.reserved(0.1), bound=False), machine)
    share = follower.piece[at.SHARE : at.ROOM].reshape(3, 5)
    random = np.random.default_rng(0)
    aims = 1e-4 * random.normal(size=(steps, 5))
    follower.reset()
    correct(follower.piece, follower.state)
    began = time.thread_time()
    for aim in aims:
        follower.state[AIM : AIM + 5] = aim
        correct(follower.piece, follower.state)
    ours = 1e6 * (time.thread_time() - began) / steps
    otg, given, answer = ruckig.Ruckig(5, 1e-3), ruckig.InputParameter(5), ruckig.OutputParameter(5)
    given.synchronization = ruckig.Synchronization.No
    given.max_velocity, given.max_acceleration, given.max_jerk = (row.tolist() for row in share)
    given.current_position = given.current_velocity = given.current_acceleration = [0.0] * 5
    took = []
    for aim in aims:
        given.target_position = aim.tolist()
        otg.update(given, answer)
        took.append(answer.calculation_duration)
        answer.pass_to_input(given)
    table = Table("Time of the correction alone, five joints, a new aim each step [us]", ["what", "mean", "median"])
    table.lines.append(["toolpace, called from Python (its call included)", f"{ours:.1f}", ""])
    table.lines.append(["ruckig, by its own clock (wall)", f"{np.mean(took):.1f}", f"{np.median(took):.1f}"])
    return table
