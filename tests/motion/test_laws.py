"""When places are passed, and the law of a path whose parameter is the time."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.motion import laws
from toolpace.motion.laws import ClockLaw, SplineLaw


def from_rest_to_rest() -> SplineLaw:
    nodes = np.linspace(0.05, 0.95, 10)
    c = np.full(12, 0.8)
    c[1] = c[0] * (1.0 + 4.0 * (nodes[1] - nodes[0]) / (9.0 * 0.05))
    c[-2] = c[-1] * (1.0 + 4.0 * (nodes[-1] - nodes[-2]) / (9.0 * 0.05))
    return SplineLaw(nodes, c, (0.05, 0.05))


def test_the_ends_are_passed_at_the_start_and_at_the_end():
    """Exactly: where a law comes to rest, rounding shows the last place microseconds before its time."""
    law = from_rest_to_rest()
    s = law.at(np.array([law.duration * (1.0 - 1e-7)]))[0, 0]
    assert s == pytest.approx(law.s1, abs=1e-15)
    assert law.passing_time(law.s1) == law.passing_time(law.s1 + 1.0) == law.duration
    assert law.passing_time(law.s0) == law.passing_time(law.s0 - 1.0) == 0.0
    for place in (0.01, 0.3, 0.97):
        assert law.at(np.array([law.passing_time(place)]))[0, 0] == pytest.approx(place, abs=1e-14)


@pytest.mark.parametrize("at_a_time", [2, 10_000])
def test_the_states_of_a_clock_cover_its_time_once(monkeypatch: pytest.MonkeyPatch, at_a_time: int):
    monkeypatch.setattr(laws, "CELLS_AT_A_TIME", at_a_time)
    nodes = np.array([2.0, 2.5, 2.6, 4.0, 4.5, 7.0])
    probes = list(ClockLaw(nodes).probes())
    s, share, right = (np.concatenate(each) for each in zip(*((p.state[0], p.share, p.right) for p in probes)))
    assert (np.diff(s) >= 0.0).all() and (s[0], s[-1]) == (2.0, 7.0)
    # both sides of every node inside, and the integrals of 1 and of s by their shares
    assert [np.count_nonzero(s == node) for node in nodes] == [1, 2, 2, 2, 2, 1]
    assert (right[np.isin(s, nodes)] == [1, 0, 1, 0, 1, 0, 1, 0, 1, 0]).all()
    assert share.sum() == pytest.approx(5.0) and share @ s == pytest.approx((49.0 - 4.0) / 2.0)
    assert all((p.state[1] == 1.0).all() and not p.state[2:].any() for p in probes)
