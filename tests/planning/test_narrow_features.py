"""Features narrower than any grid: what changes position, slope or curvature of a path is found, however narrow."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import harmonics, path_of, straight
from tests.support.bends import bend, limits_of
from toolpace.common.errors import PathError
from toolpace.machine.limits import Limits
from toolpace.motion.trajectory import Trajectory
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import plan

PLANNED, SHOWN = 1.0 / 1000.0, 1.0 / 1500.0
"""Width, as a share of the run, from which a blip that changes nothing beyond it is planned for, and shows in usage."""


def blip(random: np.random.Generator, width: float, joints: int):
    """A smooth path with a bump as wide, four times differentiable, beyond which nothing is changed."""
    place = random.uniform(0.05, 0.95)
    base = harmonics(random, joints, 3)
    bump = np.polynomial.Polynomial([1.0, 0.0, -1.0]) ** 6
    height = random.normal(size=joints) * width

    def jets(s):
        u = 2.0 * (s - place) / width
        inside = np.abs(u) < 1.0
        part = np.stack(
            [np.where(inside, (bump.deriv(k) if k else bump)(u), 0.0) * (2.0 / width) ** k for k in range(4)]
        )
        return base(s) + part[:, :, None] * height

    return path_of(jets), place


def used_about(trajectory: Trajectory, place: float, width: float) -> float:
    """Largest use of the limits while s passes from `width` before a place to as far behind it."""
    limits = trajectory.limits
    low, high = 0.0, trajectory.duration
    for _ in range(8):
        t = np.linspace(low, high, 2001)
        k = np.searchsorted(trajectory.parameter(t), [place - width, place + width])
        low, high = t[max(k[0] - 1, 0)], t[min(k[1] + 1, 2000)]
    motion = trajectory.at(np.linspace(low, high, 4001))
    shares = (motion.qd / limits.velocity, motion.qdd / limits.acceleration, motion.qddd / limits.jerk)
    return float(max(np.abs(share).max() for share in shares))


@pytest.mark.parametrize(
    ("mesh", "seeds"),
    [
        (30, range(24)), (300, range(24)), pytest.param(None, range(12), marks=pytest.mark.sweep),
        pytest.param(None, range(12, 24), marks=pytest.mark.thorough),
    ],
    ids=str,
)  # fmt: skip
def test_a_bend_of_any_width_is_planned_for(mesh, seeds):
    for seed in seeds:
        random = np.random.default_rng([seed, 11])
        joints, width = int(random.integers(1, 5)), 10.0 ** random.uniform(-8.0, -2.0)
        path, place = bend(random, width, joints)
        trajectory = plan(path, limits_of(random, joints), mesh=mesh, bound=False)
        assert used_about(trajectory, place, 4.0 * width) <= PROMISED, f"seed {seed}, width {width:g}"
        assert trajectory.usage().worst <= PROMISED


@pytest.mark.sweep
def test_a_bend_that_a_motion_passes_too_fast_shows_in_its_usage():
    """Laws planned for the path without its bend: the look at them has no nodes there."""
    for seed in range(40):
        random = np.random.default_rng([seed, 13])
        joints, width = int(random.integers(1, 5)), 10.0 ** random.uniform(-8.0, -2.0)
        path, place = bend(random, width, joints)
        limits = limits_of(random, joints)
        free = plan(path_of(straight(np.full(joints, 0.3))), limits, bound=False)
        motion = Trajectory(path, limits, free.laws)
        real = used_about(motion, place, 4.0 * width)
        if real > 1.1:
            assert motion.usage().worst == pytest.approx(real, rel=0.05) or motion.usage().worst > real


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(12), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(12, 24), marks=pytest.mark.thorough, id="many"),
    ],
)
def test_a_blip_as_wide_as_is_told_is_planned_for_and_a_narrower_one_shows(seeds):
    for seed in seeds:
        random = np.random.default_rng([seed, 17])
        joints = int(random.integers(1, 5))
        for width in (PLANNED, SHOWN):
            path, place = blip(random, width, joints)
            limits = limits_of(random, joints)
            trajectory = plan(path, limits, bound=False)
            real = used_about(trajectory, place, 0.6 * width)
            assert real <= max(PROMISED, trajectory.usage().worst * (1.0 + 1e-4)), f"seed {seed}, width {width:g}"
            if width == PLANNED:
                assert real <= PROMISED, f"seed {seed}"


@pytest.mark.parametrize("order, what", [(0, "position"), (1, "slope"), (2, "curvature")])
def test_what_jumps_is_refused_by_place_and_joint(order, what):
    """A jump is as narrow as anything can be; no motion of bounded jerk follows it."""
    for seed in range(6):
        random = np.random.default_rng([seed, 19])
        joints = int(random.integers(1, 5))
        place, size, joint = random.uniform(0.1, 0.9), 10.0 ** random.uniform(-1.0, 0.5), int(random.integers(joints))
        base = harmonics(random, joints, 3)

        def jets(s, place=place, size=size, joint=joint, base=base):
            out, u = base(s), s - place
            for k in range(order + 1):
                factor = (1.0, order, 2.0)[k] * size
                out[k, :, joint] += np.where(u > 0.0, factor * np.maximum(u, 0.0) ** (order - k), 0.0)
            return out

        with pytest.raises(PathError, match=f"the {what} of q{joint + 1} jumps at s = {place:.6f}"[:-1]):
            plan(path_of(jets), limits_of(random, joints), mesh=[None, 100][seed % 2], bound=False)


@pytest.mark.parametrize("width", [1.0 / 500.0, 1.0 / 1000.0])
def test_a_dip_of_a_cap_is_planned_for_on_a_coarse_mesh(width):
    for seed in range(6):
        random = np.random.default_rng([seed, 29])
        place, depth = random.uniform(0.2, 0.8), 10.0 ** random.uniform(0.5, 2.0)

        def cap(s, place=place, depth=depth):
            return 0.5 / (1.0 + depth * np.exp(-(((s - place) / width) ** 2)))

        path = path_of(harmonics(random, 2, 3), speed_cap=cap)
        trajectory = plan(path, limits_of(random, 2), mesh=12, bound=False)
        t = np.linspace(0.0, trajectory.duration, 40_001)[:-1]
        step = 1e-6 * trajectory.duration
        s, behind = trajectory.parameter(t), trajectory.parameter(t + step)
        most = np.maximum(np.maximum(cap(s), cap(behind)), cap(0.5 * (s + behind)))
        assert ((behind - s - 1e-15) / step / most).max() <= PROMISED, f"seed {seed}"
        assert trajectory.usage().worst <= PROMISED, f"seed {seed}"


@pytest.mark.sweep
def test_a_path_that_is_rough_everywhere_is_looked_at_to_its_end():
    """Octaves far apart on few cells: more cells tell too little of the path than are chased in the first rounds."""
    for seed in range(3):
        random = np.random.default_rng([seed, 31])
        rates = np.array([1.0, 17.0, 211.0, 1500.0]) * random.uniform(0.7, 1.4)
        size, phase = rates**-2.2 * random.normal(size=4), random.uniform(0.0, 6.3, 4)

        def jets(s, rates=rates, size=size, phase=phase):
            turn = np.outer(s, rates) + phase
            return np.stack([(size * rates**k * np.sin(turn + k * np.pi / 2)).sum(axis=1)[:, None] for k in range(4)])

        trajectory = plan(path_of(jets), Limits([1.0], [4.0], [40.0]), mesh=50, bound=False)
        assert trajectory.usage().worst <= PROMISED, f"seed {seed}"


@pytest.mark.parametrize(
    ("seed", "mesh"), [(75, 12), (104, 8), (119, 8), pytest.param(119, None, marks=pytest.mark.sweep)]
)
def test_strips_between_breaks_keep_their_caps(seed, mesh):
    """A feed that jumps to and fro within 1e-7 to 1e-4 of the run: most of its breaks are no nodes of a coarse mesh."""
    random = np.random.default_rng([seed, 5])
    low = np.sort(random.uniform(0.05, 0.95, 20))
    breaks = np.unique(np.stack([low, low + 10.0 ** random.uniform(-7.5, -4.0, 20)]))
    caps = 10.0 ** random.uniform(-3.0, 0.5, len(breaks) + 1)
    caps[::2] += 1000.0

    def speed_cap(s):
        return caps[np.searchsorted(breaks, s, side="right")]

    jerk = 10.0 ** random.uniform(2.0, 6.0)
    limits = Limits([1.0, 1.0], [np.sqrt(jerk)] * 2, [jerk] * 2)
    trajectory = plan(path_of(harmonics(random, 2), breaks=breaks, speed_cap=speed_cap), limits, mesh=mesh)
    s = np.linspace(breaks[:-1], np.nextafter(breaks[1:], 0.0), 201).ravel(order="F")
    assert (trajectory.laws[0].states_at(s)[1] / speed_cap(s)).max() <= PROMISED
    assert trajectory.usage().worst <= PROMISED
