"""Random programs over frames and tools of Fanuc, Mazak and Haas on twelve machines: where the joints must be."""

from __future__ import annotations

import pytest

from testbed.fanuc_frames.__main__ import MOST_OFF, MOST_TURNED
from testbed.fanuc_frames.held import held


def wrong(seeds):
    """Programs that are elsewhere; of the others enough are read, and far enough."""
    found = [(seed, held(seed)[0]) for seed in seeds]
    read = [each for _, each in found if not each.refused]
    assert len(read) > 0.6 * len(found) and sum(each.places for each in read) > 6 * len(read)
    return [
        (seed, each) for seed, each in found
        if each.off > MOST_OFF or each.turned > MOST_TURNED or each.length > 1e-9 or each.other
    ]  # fmt: skip


@pytest.mark.parametrize(
    "first", [pytest.param(first, marks=pytest.mark.sweep) if first >= 16 else first for first in range(0, 48, 4)]
)
def test_joints_behind_every_motion(first):
    assert wrong(range(first, first + 4)) == []


@pytest.mark.parametrize(
    "first",
    [
        pytest.param(first, marks=pytest.mark.sweep if first < 1040 else pytest.mark.thorough)
        for first in range(1000, 1240, 40)
    ],
)
def test_joints_behind_every_motion_of_many(first):
    assert wrong(range(first, first + 40)) == []
