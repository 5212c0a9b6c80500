"""The judge of random plans, which sees positions only: it agrees with what plans say of themselves."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.from_positions import used_by_positions
from testbed.jets import harmonics, path_of, straight
from testbed.random_plans import FAMILIES, WAYS, random_plan
from toolpace.kernels.motion import usage
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.planning.planner import plan

KINDS = ("velocity", "acceleration", "jerk")


@pytest.mark.parametrize("seed, mesh", [(0, None), (1, 30), (2, 300), (3, 8), (4, 100)])
def test_positions_and_usage_agree_on_any_mesh(seed, mesh):
    random = np.random.default_rng(seed)
    joints = int(random.integers(1, 6))
    limits = Limits(*(random.uniform(0.5, 2.0, joints) * base for base in (1.0, 4.0, 40.0)))
    trajectory = plan(path_of(harmonics(random, joints, 6)), limits, mesh=mesh, bound=False)
    used, found = trajectory.usage(), used_by_positions(trajectory)
    told = np.array([max(getattr(used, kind).values()) for kind in KINDS])
    # what is far from its limit is not looked at as closely
    assert (found[1:] <= told * np.where(told > 0.9, 1.0 + 1e-5, 1.01)).all()
    np.testing.assert_allclose(found[1:], told, rtol=5e-3)


def test_what_is_too_much_is_seen():
    limits = Limits([1.0, 1.0], [4.0, 4.0], [40.0, 40.0])
    path = path_of(harmonics(np.random.default_rng(5), 2))
    good = plan(path, limits, mesh=200, bound=False)
    law = good.laws[0]
    # about one place faster than the limits allow
    c = law.c.copy()
    c[120:124] *= 1.02
    worse = Trajectory(path, limits, (SplineLaw(law.nodes, c, law.rest),))
    assert used_by_positions(good).max() <= 1.0001 < 1.005 < used_by_positions(worse).max()
    # accelerations that jump have no jerk
    jumping = plan(path_of(straight([1.0, 0.5])), limits, planner="second-order")
    assert used_by_positions(jumping)[3] > 50.0


def test_plans_are_the_same_for_a_seed_and_cover_all():
    assert len(FAMILIES) == 20 and len(WAYS) == 3
    first, again = random_plan(63), random_plan(63)
    s = np.linspace(first.path.runs[0].s0, first.path.runs[0].s1, 20)
    np.testing.assert_array_equal(first.path.runs[0].evaluate(s), again.path.runs[0].evaluate(s))
    assert {random_plan(seed).family for seed in range(0, 60, 3)} == set(FAMILIES)


def test_a_coarse_mesh_keeps_its_limits_next_to_rest():
    """There a cell is long: speeds have their top between the states looked at, and what is raised on a finer mesh
    fits to the rest beside it."""
    turning = np.stack([np.array([30.0, 0.02]), np.array([0.0, 1.57])])
    limits = Limits([0.05, 3.0], [8.0, 400.0], [900.0, 9000.0])

    def jets(s):
        angle, order = turning[0, 0] * s, np.arange(4)
        shift = order[:, None] * np.pi / 2.0
        round_ = turning[0, 0] ** order[:, None]
        return np.stack([round_ * np.cos(angle + shift), 0.3 * round_ * np.sin(angle + shift)], axis=-1)

    for mesh in (8, 12, 20, 50):
        trajectory = plan(path_of(jets), limits, mesh=mesh, bound=False)
        assert used_by_positions(trajectory).max() <= 1.0001
        law = trajectory.laws[0]
        for end, side in ((law.nodes[0], 1.0), (law.nodes[-1], -1.0)):
            inside, beyond = law.states_at(np.array([end + side * 1e-9, end - side * 1e-9])).T
            assert inside[2] == pytest.approx(beyond[2], rel=1e-5)


def test_tops_never_lower_what_is_seen():
    """Of samples that curve upwards beside an end there is no top; samples at one place are ends of two sides."""
    s = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0])
    ratio = np.array([[1.0, 0.97, 0.96, 0.99, 1.0, 0.999, 0.95]]).T
    seen = ratio.copy()
    beside = usage.summits(s, seen, np.inf)
    assert not beside.any() and (seen >= ratio).all()
    # 1, 0.999, 0.95 lie on a parabola with its top between the first two
    fitted = np.polynomial.Polynomial.fit(s[4:], ratio[4:, 0], 2)
    assert seen[4, 0] == pytest.approx(fitted(fitted.deriv().roots()[0])) and seen[4, 0] > 1.0
    np.testing.assert_array_equal(np.delete(seen, 4), np.delete(ratio, 4))
    assert usage.summits(s, ratio.copy(), 1e-6).tolist() == [False] * 4 + [True, False]
