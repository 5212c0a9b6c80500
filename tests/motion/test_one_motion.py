"""Every law is one motion: what it says of ds/dt and two more derivatives is what its positions do, on any mesh.

Judged from positions alone: central differences at two steps, extrapolated after Richardson. How far these may be off
is what the two steps differ by, and rounding; a law whose positions follow another velocity is off by more.
"""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.kernels.motion import cubic_spline
from toolpace.motion.laws import ChainLaw, LawPiece, LinearLaw, QuinticLaw, SplineLaw

STENCILS = {
    1: np.array([0.0, 1.0, -8.0, 0.0, 8.0, -1.0, 0.0]) / 12.0,
    2: np.array([0.0, -1.0, 16.0, -30.0, 16.0, -1.0, 0.0]) / 12.0,
    3: np.array([1.0, -8.0, 13.0, 0.0, -13.0, 8.0, -1.0]) / 8.0,
}
"""Central differences of fourth order over seven points a step apart."""
ROUNDING = {1: 3.0, 2: 20.0, 3: 100.0}


def random_nodes(random, count):
    """Knots from 0 to 1 whose cells differ by up to a thousand times."""
    cell = 10.0 ** random.uniform(-random.choice([0.0, 1.0, 3.0]), 0.0, count)
    nodes = np.concatenate([[0.0], np.cumsum(cell)])
    return nodes / nodes[-1]


def random_spline(seed):
    """A law in motion, with z that changes by up to a thousand times from knot to knot or dips to 1e-12 of itself."""
    random = np.random.default_rng([seed, 31])
    nodes = random_nodes(random, int(10.0 ** random.uniform(0.7, 3.0)))
    if seed % 2:
        c = 10.0 ** np.cumsum(random.normal(size=len(nodes) + 2) * random.uniform(0.0, 0.7))
        return SplineLaw(nodes, c / c.max(), (0.0, 0.0))
    # (s - p)^2 + depth has its dip between two knots, and is a spline on any
    p, depth = random.uniform(0.1, 0.9), 10.0 ** random.uniform(-12.0, -1.0)
    parabola = np.array([[p * p + depth, -2.0 * p, 1.0, 0.0]])
    return SplineLaw(nodes, cubic_spline.on_finer_knots(np.array([0.0, 1.0]), parabola, nodes), (0.0, 0.0))


def disagreement(law, t, step):
    """(3, n) how far the derivatives by differences are from those that are told, over what may be explained."""
    place = t + step * np.arange(-3.0, 4.0)[:, None]
    coarse, fine = (law.at(s.ravel())[0].reshape(s.shape) for s in (place, t + (place - t) / 2.0))
    told = law.at(t)
    off = np.empty((3, len(t)))
    for k, weights in STENCILS.items():
        one, two = weights @ coarse / step**k, weights @ fine / (step / 2.0) ** k
        # rounding of a time moves s by so much more where it moves fast; that of z, where z dips, both
        size = np.abs(law.s1) + np.abs(law.s0) + told[1] * law.duration * (1.0 + digits_lost(law, told))
        noise = ROUNDING[k] * np.finfo(float).eps * size / (step / 2.0) ** k
        off[k - 1] = np.abs((16.0 * two - one) / 15.0 - told[k]) / (2.0 * np.abs(one - two) + noise)
    return off


def digits_lost(law, told):
    """(n,) z at the left node of a spline's cell over z here: a polynomial of powers from there rounds like that."""
    if not isinstance(law, SplineLaw):
        return 0.0
    cell = np.clip(np.searchsorted(law.nodes, told[0]) - 1, 0, len(law.cells) - 1)
    return np.where(told[0] < law.nodes[0], 0.0, law.cells[cell, 0] / told[1] ** 2)


def inside(law, marks, step, random, count=200):
    """(n,) times in order that are at least four steps away from the times `marks`."""
    t = np.sort(random.uniform(4.0 * step, law.duration - 4.0 * step, count))
    k = np.searchsorted(marks, t)
    near = np.minimum(t - marks[np.maximum(k - 1, 0)], marks[np.minimum(k, len(marks) - 1)] - t)
    return t[np.abs(near) > 4.0 * step]


@pytest.mark.parametrize("block", range(10))
def test_splines_of_any_mesh_are_one_motion(block):
    for seed in range(20 * block, 20 * block + 20):
        law, random = random_spline(seed), np.random.default_rng(seed)
        looked = 0
        for share in (1e-2, 1e-3, 1e-4):
            # a fourth derivative jumps at the knots
            t = inside(law, law.times, share * law.duration, random)
            looked += len(t)
            if len(t):
                assert disagreement(law, t, share * law.duration).max() < 1.0, f"seed {seed}, step {share}"
        assert looked
        assert (np.diff(law.at(np.linspace(0.0, law.duration, 1000))[0]) >= 0.0).all()


def test_differences_converge_to_what_is_told():
    for seed in range(0, 40, 2):
        law = random_spline(seed)
        t = np.linspace(0.1, 0.9, 50) * law.duration
        told = law.at(t)
        for k, weights in STENCILS.items():
            errors = []
            for share in (4e-2, 2e-2, 1e-2):
                place = t + share * law.duration / 3.0 * np.arange(-3.0, 4.0)[:, None]
                found = weights @ law.at(place.ravel())[0].reshape(place.shape) / (share * law.duration / 3.0) ** k
                errors.append(np.abs(found - told[k]).max())
            # s is analytic in time here: fourth order, until rounding takes over
            floor = 1e3 * np.finfo(float).eps / (1e-2 * law.duration / 3.0) ** k
            assert errors[2] < max(errors[0] / 100.0, floor), f"seed {seed}, derivative {k}: {errors}"


def test_times_of_dips_in_closed_form():
    for seed in range(0, 400, 2):
        law = random_spline(seed)
        random = np.random.default_rng([seed, 31])
        nodes = random_nodes(random, int(10.0 ** random.uniform(0.7, 3.0)))
        p, depth = random.uniform(0.1, 0.9), 10.0 ** random.uniform(-12.0, -1.0)
        exact = np.arcsinh((nodes - p) / np.sqrt(depth))
        # the depth is known to the rounding of the coefficients only, and time grows like its logarithm
        lost = 4.0 * np.finfo(float).eps / depth
        np.testing.assert_allclose(law.times, exact - exact[0], rtol=1e-12, atol=1e-13 + lost)


def test_next_to_rest_the_spline_is_one_motion():
    for seed in range(50):
        random = np.random.default_rng([seed, 7])
        nodes = 0.01 + 0.98 * random_nodes(random, int(random.integers(5, 300)))
        c = 10.0 ** random.uniform(-1.0, 0.0, len(nodes) + 2)
        h = 0.01
        c[1] = c[0] * (1.0 + 4.0 * (nodes[1] - nodes[0]) / (9.0 * h))
        c[-2] = c[-1] * (1.0 + 4.0 * (nodes[-1] - nodes[-2]) / (9.0 * h))
        law = SplineLaw(nodes, c, (h, h))
        for share in (1e-3, 1e-4):
            step = share * law.duration
            t = inside(law, law.times, step, random)
            t = np.unique(np.concatenate([t, [5.0 * step, law.times[0] - 5.0 * step]]))
            t = t[(t > 4.0 * step) & (np.abs(t[:, None] - law.times).min(axis=1) > 4.0 * step)]
            assert disagreement(law, t, step).max() < 1.0, f"seed {seed}"
        # position, speed and acceleration go on across the inner ends of the rest cells
        for at in (law.times[0], law.times[-1]):
            step = 1e-9 * law.duration
            (s0, v0, a0, j0), (s1, v1, a1, j1) = law.at(at + step * np.array([-1.0, 1.0])).T
            assert abs(s1 - s0 - step * (v0 + v1)) < 1e-14
            assert abs(v1 - v0 - step * (a0 + a1)) < step * abs(a1 - a0) + 1e-14
            assert abs(a1 - a0) < 1e-9 * abs(a0) + 2.0 * step * (abs(j0) + abs(j1))


def test_the_inner_ends_of_rest_cells_are_probed_at_the_nodes():
    """Rounded beyond a break there, the left side of the node would be its right one."""
    random, moved = np.random.default_rng(5), 0
    for _ in range(50):
        nodes = np.sort(random.uniform(0.1, 0.9, 4))
        h = random.uniform(0.01, 0.1, 2)
        law = SplineLaw(nodes, random.uniform(0.5, 1.0, 6), (h[0], h[1]))
        s = np.concatenate([each.state[0] for each in law.probes()])
        assert np.count_nonzero(s == nodes[0]) == np.count_nonzero(s == nodes[-1]) == 2
        third = 2.0 * law.cells[0, 0] ** 1.5 / (9.0 * h[0] ** 2)
        moved += nodes[0] - h[0] + third * law.times[0] ** 3 / 6.0 != nodes[0]
    assert moved > 5


def random_linear(random):
    nodes = random_nodes(random, int(random.integers(5, 300)))
    z = 10.0 ** random.uniform(-3.0, 0.0, len(nodes))
    z[0] *= random.integers(2)
    return LinearLaw(nodes, z)


def random_quintic(random):
    """Speeds that hardly change: quintics that run forwards."""
    points = random_nodes(random, int(random.integers(5, 40)))
    speed = random.uniform(0.9, 1.1, len(points))
    periods = 2.0 * np.diff(points) / (speed[1:] + speed[:-1])
    bend = np.maximum(np.append(periods, 0.0), np.append(0.0, periods))
    return QuinticLaw(points, speed, random.uniform(-0.1, 0.1, len(points)) / bend, periods)


@pytest.mark.parametrize("make", [random_linear, random_quintic])
def test_other_laws_and_chains_of_them_are_one_motion(make):
    for seed in range(50):
        random = np.random.default_rng([seed, 5])
        law = make(random)
        cut = law.duration * np.sort(random.uniform(0.1, 0.9, 3))
        pieces = [LawPiece(law, a, b) for a, b in zip([0.0, *cut], [*cut, law.duration])]
        for one, marks in ((law, law.times), (ChainLaw(pieces), np.union1d(law.times, cut))):
            looked = 0
            for share in (1e-3, 1e-4, 1e-5):
                t = inside(one, marks, share * law.duration, random)
                looked += len(t)
                if len(t):
                    assert disagreement(one, t, share * law.duration).max() < 1.0, f"seed {seed}"
            assert looked
