"""Meshes with breaks next to each other: what is narrow is neither lost nor spoils the rest."""

import numpy as np
import pytest

from testbed.from_positions import used_by_positions
from testbed.random_plans import random_plan
from toolpace.common.errors import InfeasibleError
from toolpace.machine.limits import Limits
from toolpace.path.axis_path import AxisPath
from toolpace.planning.mesh import nodes as mesh
from toolpace.planning.mesh.initial_guess import guess
from toolpace.planning.mesh.nodes import MOST_UNLIKE, at_caps, graded
from toolpace.planning.planner import plan


@pytest.mark.parametrize(
    ("seed", "why"),
    [
        (1000871, "a break in the first cell of a motion was dropped: 1400 times the acceleration"),
        (1000804, "a bend beside the end of a long cell next to rest fell between two looks: 1.003"),
        pytest.param(
            1005858,
            "a bend of 1e-7 of the run between nine probes of a cell: jerk 7e9 times its limit",
            marks=pytest.mark.sweep,
        ),
        pytest.param(1005020, "the same in motion on a fixed mesh: 35 000 times", marks=pytest.mark.sweep),
        (1001824, "a bend of the third derivative at a hint of the path, inside a cell of a fixed mesh: 1.01"),
        (1003624, "the same between two hints inside a cell: 1.019"),
        (1007407, "a top between probes that were at 0.94 of the limit: 1.0006"),
        pytest.param(
            1001037, "the same beside a place where all joints stand: 1.012, told and not to be seen in positions",
            marks=pytest.mark.sweep,
        ),
    ],
)
def test_what_is_narrow_is_seen(seed, why):
    made = random_plan(seed)
    try:
        trajectory = plan(made.path, made.limits, **made.options)
    except InfeasibleError:
        # the state is taken from another plan and differs by the processor's rounding; in motion on a fixed mesh a plan
        # may be refused, on a mesh of the planner's own it must be found
        assert {"start", "mesh"} <= made.options.keys()
        trajectory = plan(made.path, made.limits, start=made.options["start"])
    assert used_by_positions(trajectory).max() < 1.0001, why
    assert trajectory.usage().worst < 1.0001


def test_blends_far_shorter_than_the_cells_do_not_keep_the_spline_from_moving():
    """The solver gave up, and all was slowed down to 17 000 s."""
    made = random_plan(1001230)
    assert plan(made.path, made.limits, **made.options).duration < 20.2


def test_breaks_next_to_each_other_do_not_keep_the_solver_from_its_end():
    """Cells of 4e-10 of the run between breaks made the curvature of z noise: all was slowed down to 761 s."""
    made = random_plan(1003308)
    assert plan(made.path, made.limits, **made.options).duration < 7.75


def test_cells_side_by_side_are_alike():
    random = np.random.default_rng(5)
    for _ in range(200):
        nodes = np.unique(np.concatenate([random.uniform(size=20), 0.5 + 10.0 ** random.uniform(-9, -1, 12)]))
        cell = np.diff(graded(nodes))
        assert np.isin(nodes, graded(nodes)).all()
        assert max((cell[1:] / cell[:-1]).max(), (cell[:-1] / cell[1:]).max()) <= MOST_UNLIKE


LIMITS = Limits([1.0, 1.0], [5.0, 5.0], [50.0, 50.0], ["X", "Y"])


def bend_between_straights(speed_cap, breaks=()):
    """A path of 2 m with a bend of 20 mm in its middle, that asks for a quarter of the feed of 0.1 m/s."""

    def f(s, order):
        x, width = s - 1.0, 1e-2
        e = np.exp(-((x / width) ** 2) / 2.0)
        u = x / width
        bend = (e, -u * e / width, (u**2 - 1.0) * e / width**2, (3.0 - u**2) * u * e / width**3)[order]
        return np.stack([(s, np.ones_like(s), 0.0 * s, 0.0 * s)[order], 0.05 * bend], axis=1)

    return AxisPath.from_callable(
        f, 0.0, 2.0, joints=["X", "Y"], speed_cap=speed_cap, breaks=breaks, hints=np.linspace(0.0, 2.0, 41)
    )


def test_where_the_feed_holds_the_motion_cells_are_long_and_nothing_is_lost(monkeypatch):
    path = bend_between_straights(0.1)
    long = plan(path, LIMITS)
    monkeypatch.setattr(mesh, "COARSEST", 1.0)
    even = plan(path, LIMITS)
    assert long.mesh_points < 0.6 * even.mesh_points
    assert long.duration == pytest.approx(even.duration, rel=2e-5)
    assert 0.0 <= long.gap < 1e-3
    assert used_by_positions(long).max() < 1.0001
    assert 2.0 / 0.1 < long.lower_bound <= even.duration


def test_a_feed_in_waves_is_followed(monkeypatch):
    """In cells as long as at an even feed the motion would take 6e-4 and 2e-4 longer."""
    for height, waves in ((0.01, 120.0), (0.3, 40.0)):
        path = bend_between_straights(lambda s, height=height, waves=waves: 0.1 * (1.0 + height * np.sin(waves * s)))
        with monkeypatch.context() as patched:
            patched.setattr(mesh, "COARSEST", 1.0)
            even = plan(path, LIMITS, bound=False)
        followed = plan(path, LIMITS)
        assert followed.mesh_points < even.mesh_points
        assert followed.duration == pytest.approx(even.duration, rel=5e-5)
        assert followed.lower_bound <= even.duration


def test_a_place_where_the_cap_falls_is_not_at_its_cap_from_either_side():
    step = 1.3
    for cap in (lambda s: np.where(s < step, 0.1, 0.05), lambda s: np.where(s < step, 0.05, 0.1)):
        run = bend_between_straights(cap, [step]).runs[0]
        rough = guess(run, LIMITS, (0.0, 0.0), 400)
        at_cap = at_caps(run, LIMITS, rough)
        assert not at_cap[rough.s == step].any()
        assert at_cap[np.abs(rough.s - 1.6) < 0.1].all() and not at_cap[[0, -1]].any()
        # the bend takes a half of the feed as it is
        assert at_cap[np.abs(rough.s - 1.0) < 5e-3].any() == (cap(1.0) == 0.05)
