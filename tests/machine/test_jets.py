"""Derivatives along a path to third order, against finite differences and their rates of convergence."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.growth import python_calls
from tests.support.machines import CLASSES, random_machine
from toolpace.machine.machine import Machine

STENCILS = {
    1: (np.array([-1, 1]), np.array([-0.5, 0.5])),
    2: (np.array([-1, 0, 1]), np.array([1.0, -2.0, 1.0])),
    3: (np.array([-2, -1, 1, 2]), np.array([-0.5, 1.0, -1.0, 0.5])),
}
"""Central differences with errors of second order in the step."""


def curve(rng: np.random.Generator, columns: int, size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return size * rng.normal(size=columns), rng.uniform(0.5, 2.0, columns), rng.uniform(0, 6, columns)


def jets(shape: tuple[np.ndarray, np.ndarray, np.ndarray], s: np.ndarray) -> np.ndarray:
    """Derivatives 0..3 (4, n, columns) of size * sin(rate * s + phase)."""
    size, rate, phase = shape
    angle = rate * s[:, None] + phase
    return np.stack([size * rate**k * np.sin(angle + k * np.pi / 2) for k in range(4)])


def difference(f, s: np.ndarray, order: int, h: float) -> np.ndarray:
    offsets, weights = STENCILS[order]
    return sum(w * f(s + o * h) for o, w in zip(offsets, weights)) / h**order


def assert_second_order(f, exact: np.ndarray, s: np.ndarray) -> None:
    """Differences of f approach the derivatives (4, n, ...) four times closer for half the step."""
    np.testing.assert_allclose(f(s), exact[0], atol=1e-12)
    for order in (1, 2, 3):
        scale = 1.0 + np.abs(exact[order]).max()
        coarse, fine = (np.abs(difference(f, s, order, h) - exact[order]).max() / scale for h in (0.02, 0.01))
        assert coarse < 0.02
        assert coarse < 1e-9 or 3.0 < coarse / fine < 5.0


def machines() -> list[Machine]:
    rng = np.random.default_rng(5)
    return [Machine.load(name) for name in Machine.names()] + [
        random_machine(rng, kind) for kind in CLASSES for _ in range(5)
    ]


@pytest.mark.parametrize("machine", machines(), ids=lambda machine: machine.name)
def test_linear_and_axis_jets(machine: Machine) -> None:
    rng = np.random.default_rng(6)
    tip, rotary = curve(rng, 3, 0.1), curve(rng, 2, 0.3)
    s = np.linspace(0, 2, 7)
    q = machine.linear_jets(jets(tip, s), jets(rotary, s))
    assert_second_order(lambda s: machine.joints_at(jets(tip, s)[0], jets(rotary, s)[0]), q, s)
    np.testing.assert_array_equal(q[:, :, machine.rotary], jets(rotary, s))
    assert_second_order(lambda s: machine.axis_at(jets(rotary, s)[0]), machine.axis_jets(jets(rotary, s)), s)


@pytest.mark.parametrize("machine", machines(), ids=lambda machine: machine.name)
def test_rotary_jets_invert_axis_jets(machine: Machine) -> None:
    """From rotary joints to the axis and back, on the given branch and turn."""
    rng = np.random.default_rng(7)
    swing = jets(curve(rng, 2, 0.2), np.linspace(0, 2, 50))
    compared = 0
    for middle in (0.9, 2.4, 4.0):
        given = swing.copy()
        given[0] += [2 * np.pi + 0.3, middle]
        axis = machine.axis_jets(given)
        back = machine.rotary_jets(axis, given[0] + 0.01)
        # Where both solutions nearly meet, at the edge of reach, "nearest" means little.
        solutions, _ = machine.rotary_solutions(axis[0])
        apart = np.linalg.norm(np.sin((solutions[:, 0] - solutions[:, 1]) / 2), axis=1) > 0.3
        compared += apart.sum()
        for order, tolerance in enumerate((1e-12, 1e-11, 1e-10, 1e-9)):
            np.testing.assert_allclose(back[order, apart], given[order, apart], atol=tolerance)
    assert compared > 50


def test_rotary_jets_through_the_pole() -> None:
    """An axis that swings straight through the pole: the free joint rests, the other runs through evenly."""
    machine = Machine.load("xyzac-trunnion")
    given = np.zeros((4, 5, 2))
    given[0] = np.stack([np.full(5, 0.7), np.linspace(-0.2, 0.2, 5)], axis=1)
    given[1, :, 1] = 1.3
    given[2, :, 1] = -0.4
    back = machine.rotary_jets(machine.axis_jets(given), given[0])
    np.testing.assert_allclose(back, given, atol=1e-10)


def test_rotary_jets_out_of_reach_are_nan() -> None:
    axis = np.zeros((4, 1, 3))
    axis[0, 0] = [0, 0.6, -0.8]
    assert np.isnan(Machine.load("xyzbc-nutating").rotary_jets(axis, np.zeros((1, 2)))).all()


def test_jets_are_found_in_compiled_loops() -> None:
    """The interpreter does as much for ten points as for twenty thousand."""
    machine = Machine.load("xyzac-trunnion")
    rng = np.random.default_rng(8)
    tip, rotary = rng.normal(size=(4, 20_001, 3)), rng.normal(size=(4, 20_001, 2))
    machine.linear_jets(tip[:, :2], rotary[:, :2])
    few, many = (python_calls(lambda n=n: machine.linear_jets(tip[:, :n], rotary[:, :n])) for n in (10, 20_000))
    assert few == many
