"""A caller's derivatives are held against differences of what they are derivatives of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import toolpace as tp
from testbed.nasty_paths import FAMILIES, case

PERIOD = 2.0 * np.pi


def circle(s: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """A circle of 50 mm, the tool axis leaning outwards by 0.1 rad."""
    out = np.stack([np.cos(s + 0.5 * np.pi * order), np.sin(s + 0.5 * np.pi * order), 0.0 * s], axis=1)
    return 0.05 * out, np.sin(0.1) * out + np.array([0.0, 0.0, np.cos(0.1) * (order == 0)])


def spoiled(wrong: int, part: int, factor: float) -> Callable[[np.ndarray, int], Any]:
    """The circle with one derivative of tip or axis that many times as large."""

    def f(s: np.ndarray, order: int) -> tuple[np.ndarray, ...]:
        parts = circle(s, order)
        return tuple(value * (factor if order == wrong and k == part else 1.0) for k, value in enumerate(parts))

    return f


def test_right_derivatives_are_taken() -> None:
    path = tp.Path.from_callable(circle, 0.0, PERIOD)
    machine = tp.Machine.load("xyzac-trunnion")
    assert tp.plan(path, machine, bound=False).usage().worst <= 1.0001


def test_a_joint_that_stands_but_for_rounding_of_larger_terms_is_taken() -> None:
    """A sum of terms of 0.2 m that cancel, as inverse kinematics of a standing tip give them."""

    def joints(s: np.ndarray, order: int) -> np.ndarray:
        wave = np.stack([0.2 * np.sin(k * s + 0.5 * np.pi * order) * float(k) ** order for k in range(1, 9)])
        rest = sum(wave) - sum(wave[::-1])
        return np.stack([wave[1], 1e-3 * rest if order == 0 else 0.0 * s], axis=1)

    assert tp.plan(tp.AxisPath.from_callable(joints, 0.0, 1.0), tp.Limits([1.0] * 2, [1.0] * 2, [10.0] * 2)).gap < 0.01


@pytest.mark.parametrize("factor", [0.0, 0.5, 0.99, 1.01, 2.0, -1.0, 180.0 / np.pi])
@pytest.mark.parametrize("part", [0, 1])
@pytest.mark.parametrize("wrong", [1, 2, 3])
def test_a_wrong_derivative_is_refused_with_its_place(wrong: int, part: int, factor: float) -> None:
    which = ("tip", "axis")[part]
    name = rf"f\(s, {wrong}\) is not the derivative of f\(s, {wrong - 1}\): at s = [0-9.e-]+ .* {which} [xy]"
    # a wrong middle derivative is no derivative of the one below, and has none above it
    above = rf"f\(s, {wrong + 1}\) is not the derivative of f\(s, {wrong}\): at s = [0-9.e-]+ "
    with pytest.raises(tp.ToolpaceError, match=f"{name}|{above}") as caught:
        tp.Path.from_callable(spoiled(wrong, part, factor), 0.0, PERIOD)
    assert "\n" not in str(caught.value)


def test_the_place_and_both_figures_are_true() -> None:
    with pytest.raises(tp.ToolpaceError) as caught:
        tp.AxisPath.from_callable(lambda s, order: (s**2, 6.0 * s, 2.0 + 0.0 * s, 0.0 * s)[order][:, None], 1.0, 3.0)
    s = float(str(caught.value).partition("at s = ")[2].split()[0])
    told = float(str(caught.value).partition(" it is ")[2].split()[0])
    found = float(str(caught.value).partition("changes by ")[2].split(";")[0])
    assert 1.0 <= s <= 3.0
    assert told == pytest.approx(6.0 * s, rel=1e-3) and found == pytest.approx(2.0 * s, rel=1e-3)


def test_a_derivative_that_is_wrong_on_a_part_of_the_path_is_found() -> None:
    def f(s: np.ndarray, order: int) -> np.ndarray:
        value = np.sin(3.0 * s + 0.5 * np.pi * order) * 3.0**order
        return np.where((s > 0.4) & (s < 0.5) & (order == 1), 1.5 * value, value)[:, None]

    with pytest.raises(tp.ToolpaceError, match=r"f\(s, 1\) is not .* at s = 0\.4[0-9]+ "):
        tp.AxisPath.from_callable(f)


@pytest.mark.parametrize("seed", range(4))
def test_jumps_of_the_third_derivative_and_narrow_turns_are_none(seed: int) -> None:
    """A spline of degree three between many knots, none of them told; waves of up to 100 000 on the path."""
    from scipy.interpolate import CubicSpline

    rng = np.random.default_rng(seed)
    knots = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.0, 1.0, 60)]))
    spline = CubicSpline(knots, rng.normal(size=(62, 3)))
    tp.AxisPath.from_callable(lambda s, order: spline(s, nu=order))
    for waves in (10.0, 1e3, 1e5):
        tp.AxisPath.from_callable(
            lambda s, order, w=waves: (np.sin(w * s + 0.5 * np.pi * order) * w**order + 1e3 * (order == 0))[:, None]
        )
    far = 1e4 * rng.uniform(-1.0, 1.0)
    tp.AxisPath.from_callable(lambda s, order: np.exp(s - far)[:, None] + 7.0 * (order == 0), far, far + 1e-3)


@pytest.mark.parametrize("family", FAMILIES)
def test_nasty_paths_are_taken_as_they_are(family: str) -> None:
    for seed in range(5):
        assert case(family, seed) is not None


@pytest.mark.parametrize(
    ("f", "message"),
    [
        (lambda s, order: (circle(s, order)[0], 2.0 * circle(s, order)[1]), "the tool axis has the length 2 at s = "),
        (lambda s, order: (circle(s, order)[0] * np.nan, circle(s, order)[1]), r"f\(s, 0\) is not finite at s = "),
        (lambda s, order: circle(s, order)[0], r"f\(s, order\) is not a pair"),
        (lambda s, order: (circle(s, order)[0][:, :2], circle(s, order)[1]), r"tip of f\(s, 0\) has shape \(640, 2\)"),
        (lambda s, order: (circle(s, order)[0] * 1j, circle(s, order)[1]), r"the tip of f\(s, 0\) .* of complex128"),
        (lambda s, order: (circle(s, order)[0], np.full((len(s), 3), "x")), r"the tool axis of f\(s, 0\) .* of <U1"),
        (lambda s, order: (circle(s, order)[0][1:], circle(s, order)[1]), r"the tip of f\(s, 0\) has shape \(639, 3\)"),
    ],
)  # fmt: skip
def test_what_is_no_path_is_one_error(f: Any, message: str) -> None:
    with pytest.raises(tp.ToolpaceError, match=message) as caught:
        tp.Path.from_callable(f, 0.0, PERIOD)
    assert "\n" not in str(caught.value)
