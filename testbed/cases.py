"""The paths of the comparisons: three from papers, on five-axis machines, and random smooth ones of five joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed import published
from testbed.jets import path_of
from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.axis_path import AxisPath
from toolpace.path.axis_run import AxisRun
from toolpace.path.path import Path

RANDOM_CASES = 24
MODES = 5


@dataclass(frozen=True, eq=False)
class Case:
    """A path of the joints, and their limits."""

    name: str
    axis_path: AxisPath
    limits: Limits
    source: str = ""

    @property
    def run(self) -> AxisRun:
        """The one run of the path."""
        return self.axis_path.runs[0]


def followed(name: str, path: Path, machine: Machine, source: str) -> Case:
    """The joints of a machine along a path, behind a plain callable, as a caller without a machine would have it."""
    axis_path = AxisPath.follow(path, machine)
    run = axis_path.runs[0]
    bare = path_of(run.evaluate, run.s0, run.s1, joints=machine.joints, speed_cap=run.speed_cap, breaks=run.breaks)
    return Case(name, bare, machine.limits, source)


def flank() -> Case:
    """Ma et al. 2022: a flank pass."""
    return followed("flank", *published.flank(), "JCDE 2022")


def fan() -> Case:
    """Zhang et al. 2021: 25 points."""
    return followed("fan", *published.fan(), "IJMS 2021")


def paper_arc() -> Case:
    """Wu, Li, Liu and Perez 2009: the quarter circle at 30 mm/s; in closed form 5.3112 s."""
    return followed("paper arc", Path.paper_arc(), Machine.load("paper-ab"), "ACC 2009")


def random_case(seed: int, modes: int = MODES) -> Case:
    """Five joints, each a sum of harmonics with random phases; every second one with a fifth of the jerk."""
    rng = np.random.default_rng(1000 + seed)
    number = np.arange(1, modes + 1)
    scale = rng.uniform(0.2, 1.0, 5) / number[:, None] ** 1.5
    sine, cosine = rng.normal(size=(2, modes, 5)) * scale
    omega = np.pi * number
    # the derivatives of all orders from sines and cosines by one product
    weights = np.empty((2 * modes, 4, 5))
    for order in range(4):
        turn = np.exp(0.5j * np.pi * order) * omega[:, None] ** order
        weights[:modes, order] = turn.real * sine - turn.imag * cosine
        weights[modes:, order] = turn.imag * sine + turn.real * cosine
    flat = weights.reshape(2 * modes, 20)

    def jets(s: Floats) -> Floats:
        angle = s[:, None] * omega
        basis = np.concatenate([np.sin(angle), np.cos(angle)], axis=1)
        return (basis @ flat).reshape(len(s), 4, 5).transpose(1, 0, 2)

    tight = seed % 2 == 1
    kind = "random" if modes == MODES else f"{modes} harmonics"
    limits = Limits(
        rng.uniform(0.5, 2.0, 5), rng.uniform(1.5, 6.0, 5), rng.uniform(10.0, 40.0, 5) * (0.2 if tight else 1.0)
    )
    name = f"{kind} {seed:02d}" + (" tight" if tight else "")
    return Case(name, path_of(jets), limits, "fixed seed")


def all_cases(random: int = RANDOM_CASES) -> list[Case]:
    """The published paths and the first random ones."""
    return [flank(), fan(), paper_arc(), *(random_case(seed) for seed in range(random))]
