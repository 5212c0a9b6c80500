"""A replanned law is taken only where it begins as it shall and keeps what is promised; else the direct one is."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from toolpace.common.errors import InfeasibleError
from toolpace.deflection import detour_law
from toolpace.motion.laws import ChainLaw, LawPiece, TimeLaw
from toolpace.planning.limit_tolerances import PROMISED


class Law:
    def __init__(self, duration, begin=(0.0, 0.02, 0.3, 0.0)):
        self.duration, self.begin = duration, np.array(begin)[:, None]

    def at(self, t):
        return self.begin


class Cube(TimeLaw):
    """s = t^3 / 1000."""

    s0, s1, duration = 0.0, 1.0, 10.0

    def at(self, t):
        return np.stack([t**3, 3.0 * t**2, 6.0 * t, np.full_like(t, 6.0)]) / 1000.0

    def probes(self):
        yield from ()


RUN = SimpleNamespace(
    s0=0.0, s1=1.0, breaks=np.empty(0), hints=np.empty(0), smooth=True, ends_here=True, machine=None,
    tool_length=np.nan,
    detour=SimpleNamespace(duration=2.0),
)  # fmt: skip
LIMITS = SimpleNamespace(joints=("X",))
DIRECT = Law(2.0)


def found_with(monkeypatch, law, worst=1.0, run=RUN, direct=DIRECT):
    """What is taken where the planner finds a law, with the usage that it is found to have."""
    usage = lambda: SimpleNamespace(worst=worst)  # noqa: E731
    monkeypatch.setattr(detour_law, "AxisPath", lambda *given: None)
    monkeypatch.setattr(detour_law, "Trajectory", lambda *given: SimpleNamespace(usage=usage))
    planner = SimpleNamespace(plan_run=lambda *given: SimpleNamespace(law=law))
    return detour_law.planned_law(run, LIMITS, direct, planner)


def taken(monkeypatch, law, worst=1.0):
    """Whether the planner's law is taken."""
    found = found_with(monkeypatch, law, worst)
    assert found in (law, DIRECT)
    return found is law


@pytest.mark.parametrize(
    ("worst", "fine"), [(0.9, True), (PROMISED, True), (1.00011, False), (1.005, False), (2.0, False)]
)
def test_a_law_that_passes_a_limit_is_not_taken(monkeypatch, worst, fine):
    assert taken(monkeypatch, Law(1.0), worst) == fine


@pytest.mark.parametrize(("duration", "fine"), [(1.0, True), (1.9999, True), (2.0, False), (2.1, False)])
def test_a_law_that_is_no_faster_is_not_taken(monkeypatch, duration, fine):
    assert taken(monkeypatch, Law(duration)) == fine


@pytest.mark.parametrize(
    ("begin", "fine"),
    [
        ((0.0, 0.02, 0.3, 9.0), True), ((0.0, 0.02 * (1 + 1e-10), 0.3, 0.0), True),
        ((0.0, 0.02 * (1 + 1e-6), 0.3, 0.0), False), ((0.0, 0.0201, 0.3, 0.0), False), ((0.0, 0.0, 0.3, 0.0), False),
        ((0.0, 0.02, 0.3001, 0.0), False), ((0.0, 0.02, -0.3, 0.0), False), ((0.0, 0.02, 0.0, 0.0), False),
    ],
)  # fmt: skip
def test_a_law_that_begins_in_another_state_is_not_taken(monkeypatch, begin, fine):
    assert taken(monkeypatch, Law(1.0, begin)) == fine


@pytest.mark.parametrize(
    ("speed", "acceleration", "fine"),
    [(1.0, 1.0, True), (1.0 + 1e-11, 1.0, True), (1.001, 1.0, False), (1.0, 0.999, False), (0.0, 0.0, False)],
)  # fmt: skip
def test_a_law_that_ends_before_the_run_does_must_meet_the_law_that_is_known(monkeypatch, speed, acceleration, fine):
    """At 4 s, twice the detour's 2 s; what is known goes on from there, a second sooner."""
    cube = Cube()
    direct = ChainLaw([LawPiece(cube, 0.0, 2.0), LawPiece(cube, 2.0, 10.0)])
    run = SimpleNamespace(**{**vars(RUN), "ends_here": False})
    end = [0.064, 0.048 * speed, 0.024 * acceleration, 0.0]
    law = SimpleNamespace(duration=3.0, at=lambda t: np.where(t > 2.9, np.array([end]).T, 0.0))
    found = found_with(monkeypatch, law, run=run, direct=direct)
    assert (found is not direct) == fine
    if fine:
        assert found.duration == pytest.approx(9.0)
        t = np.linspace(3.1, 9.0, 20)
        assert found.at(t) == pytest.approx(direct.at(t + 1.0))


def test_where_the_planner_finds_no_motion_the_direct_law_is_taken():
    def refuse(*given):
        raise InfeasibleError("no motion")

    assert detour_law.planned_law(RUN, LIMITS, DIRECT, SimpleNamespace(plan_run=refuse)) is DIRECT


def test_where_the_path_goes_on_in_another_slope_no_planner_is_asked():
    run = SimpleNamespace(**{**vars(RUN), "smooth": False, "ends_here": False})
    assert detour_law.planned_law(run, LIMITS, DIRECT, None) is DIRECT
