"""Quintic intervals and the chain rule, Eq. (7a) to (7e) of Wu, Li, Liu, Perez, ACC 2009."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.kernels.motion import quintic

RANDOM = np.random.default_rng(7)


def wave(s: np.ndarray, order: int) -> np.ndarray:
    return np.stack([np.sin(s + order * np.pi / 2), 2.0**order * np.cos(2 * s + order * np.pi / 2)], axis=-1)


def interval(knots: np.ndarray) -> np.ndarray:
    return quintic.coefficients(knots, wave(knots, 0), wave(knots, 1), wave(knots, 2))


def test_eq7b_meets_value_and_two_derivatives_at_both_ends() -> None:
    for _ in range(100):
        knots = np.sort(RANDOM.uniform(-2, 2, 2)) + np.array([0.0, 0.1])
        value, first, second = RANDOM.normal(size=(3, 2, 5))
        found = quintic.evaluate(knots, quintic.coefficients(knots, value, first, second), knots)
        scale = max(1.0, float(np.diff(knots)[0]) ** -2)
        for wanted, got in zip((value, first, second), found[:3]):
            np.testing.assert_allclose(got, wanted, atol=1e-12 * scale, rtol=1e-12)


def test_eq7b_errata_d3_lacks_its_half() -> None:
    """With D3 = r(k+1)'' - 2 C2 as printed the end has the second derivative 2 r(k+1)'' - r(k)''."""
    r0, r0d, r0dd, r1, r1d, r1dd = RANDOM.normal(size=6)
    c1, c2 = r0d, r0dd / 2
    d1, d2, d3 = r1 - r0 - c1 - c2, r1d - c1 - 2 * c2, r1dd - 2 * c2
    printed = np.polynomial.Polynomial(
        [r0, c1, c2, 10 * d1 - 4 * d2 + d3, -15 * d1 + 7 * d2 - 2 * d3, 6 * d1 - 3 * d2 + d3]
    )
    assert printed(1) == pytest.approx(r1)
    assert printed.deriv()(1) == pytest.approx(r1d)
    assert printed.deriv(2)(1) == pytest.approx(2 * r1dd - r0dd)
    assert abs(printed.deriv(2)(1) - r1dd) > 1e-3
    ends = np.array([[r0, r0d, r0dd], [r1, r1d, r1dd]]).T[:, :, None]
    ours = quintic.coefficients(np.array([0.0, 1.0]), *ends)
    assert quintic.evaluate(np.array([0.0, 1.0]), ours, np.array([1.0]))[2, 0, 0] == pytest.approx(r1dd)


def test_continuous_to_the_second_derivative_and_third_jumps() -> None:
    knots = np.array([0.0, 0.3, 0.9, 1.5, 2.0])
    polynomials = interval(knots)
    inner = knots[1:-1]
    right = quintic.evaluate(knots, polynomials, inner)
    left = [quintic.evaluate(knots[: k + 2], polynomials[: k + 1], inner[k : k + 1])[:, 0] for k in range(3)]
    np.testing.assert_allclose(np.stack(left, 1)[:3], right[:3], atol=1e-11)
    assert np.abs(np.stack(left, 1)[3] - right[3]).max() > 1e-4


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_are_those_of_finite_differences(order: int) -> None:
    knots = np.linspace(0.0, 2.0, 6)
    polynomials = interval(knots)
    s, step = np.linspace(0.05, 1.95, 37), 1e-5
    s = s[np.abs(s[:, None] - knots).min(axis=1) > 2 * step]
    low, high = (quintic.evaluate(knots, polynomials, s + d)[order - 1] for d in (-step, step))
    np.testing.assert_allclose((high - low) / (2 * step), quintic.evaluate(knots, polynomials, s)[order], atol=2e-7)


def test_error_falls_with_the_sixth_power_of_the_interval() -> None:
    s = np.linspace(0.0, 2.0, 1001)
    errors = []
    for n in (4, 8, 16):
        knots = np.linspace(0.0, 2.0, n + 1)
        errors.append(np.abs(quintic.evaluate(knots, interval(knots), s)[0] - wave(s, 0)).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates == pytest.approx([6, 6], abs=0.2)


def law(t: np.ndarray) -> np.ndarray:
    """A parameter over time and its derivatives, for differencing."""
    return np.stack([0.3 * t + 0.2 * t**2 - 0.05 * t**3, 0.3 + 0.4 * t - 0.15 * t**2, 0.4 - 0.3 * t, -0.3 + 0 * t])


def tip(u: np.ndarray, order: int) -> np.ndarray:
    half = order * np.pi / 2
    return np.stack([np.sin(u + half), np.cos(u + half), 0.7**order * np.exp(0.7 * u)], axis=-1)


def test_eq7c_and_7d_feed_and_its_rate() -> None:
    """The parameter's rates give back the speed along the tip's path and its rate of change."""
    t, step = np.linspace(0.1, 1.5, 20), 1e-5
    u = law(t)
    speed = [quintic.feed_rate(tip(law(t + d)[0], 1), law(t + d)[1]) for d in (-step, 0.0, step)]
    acceleration = (speed[2] - speed[0]) / (2 * step)
    found = quintic.parameter_rates(tip(u[0], 1), tip(u[0], 2), speed[1], acceleration)
    np.testing.assert_allclose(found[0], u[1], rtol=1e-12)
    np.testing.assert_allclose(found[1], u[2], atol=1e-8)


def test_eq7d_errata_remainder_is_of_second_order() -> None:
    """u(t + T) less the printed terms falls faster than T^2, hence o(T^2), not only o(T)."""
    steps = np.array([0.1, 0.05, 0.025])
    u, du, ddu, _ = law(np.array([0.4]))
    rest = [abs(law(np.array([0.4 + h]))[0] - u - h * du - h * h / 2 * ddu)[0] for h in steps]
    assert np.log2(np.array(rest[:-1]) / rest[1:]) == pytest.approx([3, 3], abs=1e-6)


def test_eq7e_errata_jerk_needs_its_third_term() -> None:
    t, step = np.linspace(0.1, 1.5, 20), 1e-4
    jets = np.stack([tip(law(t)[0], order) for order in range(4)])
    motion = quintic.axis_motion(jets, law(t)[1:])
    position = [tip(law(t + k * step)[0], 0) for k in range(-2, 3)]
    np.testing.assert_allclose(motion[0], (position[3] - position[1]) / (2 * step), atol=1e-7)
    np.testing.assert_allclose(motion[1], (position[3] - 2 * position[2] + position[1]) / step**2, atol=1e-6)
    jerk = (position[4] - 2 * position[3] + 2 * position[1] - position[0]) / (2 * step**3)
    np.testing.assert_allclose(motion[2], jerk, atol=1e-3)
    printed = motion[2] - jets[1] * law(t)[3][:, None]
    assert np.abs(printed - jerk).max() > 0.1


def test_eq7e_errata_the_missing_term_is_all_there_is_at_rest() -> None:
    jets = np.stack([tip(np.zeros(1), order) for order in range(4)])
    rates = np.array([[0.0], [0.0], [2.0]])
    np.testing.assert_allclose(quintic.axis_motion(jets, rates)[2], 2.0 * jets[1])
