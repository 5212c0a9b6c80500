"""A program with several tools: what is measured, corrected and limited is of the tool in the spindle."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from testbed.followed.two_tools import followed, planned
from toolpace.common.errors import UsageError
from toolpace.deflection.following import Follower, Status
from toolpace.deflection.following.samples import followed_joints_of, samples_of
from toolpace.kernels.follow import layout

BENDING = np.array([60e-6, -40e-6, 30e-6])
FALSE = Status.ABSURD | Status.LATE | Status.NOT_A_NUMBER | Status.AT_LIMIT | Status.STOPPING


@pytest.fixture(scope="module")
def trunnion():
    """A case with tools of 120 and 197.5 mm, its plan and its machine, whose file says 150."""
    return planned(3, "xyzac-trunnion", "m428", [0.12, 0.1975])


def refuse(found):
    assert found.tip <= 8e-6 and not found.said & FALSE, found
    assert found.feed <= 1.0 + 0.02 + np.sqrt(3.0) * 0.1 and found.limits <= 1.0 + 1e-4, found


def test_a_bent_tip_of_either_tool_is_brought_back(trunnion):
    case, trajectory, machine = trunnion
    assert {cut.length for cut in case.cuts} == set(trajectory.axis_path.tool_lengths) == {0.12, 0.1975}
    assert machine.tool_length not in (0.12, 0.1975)
    refuse(followed(case, trajectory, machine, BENDING))


@pytest.mark.sweep
@pytest.mark.parametrize(
    "name, mode, lengths",
    [
        ("xyzbc-head", "g43.4", [0.096, 0.16]),
        ("xyzbc-nutating", "traori", [0.16, 0.07]),
        ("xyzbc-millturn", "m128", [0.104, 0.172]),
        ("xyzbc-table", "cldata", [0.26, 0.16]),
    ],
)
def test_and_on_other_machines(name: str, mode: str, lengths: list[float]):
    case, trajectory, machine = planned(3, name, mode, lengths, points=12)
    refuse(followed(case, trajectory, machine, BENDING, max_turn=0.01))


def test_the_feed_is_that_of_the_tip_of_each_tool(trunnion):
    case, trajectory, machine = trunnion
    samples = samples_of(trajectory, followed_joints_of(machine, machine.joints), 8e-3, 1.0)
    run = trajectory.run_at(np.minimum(2e-3 * np.arange(len(samples.q)), trajectory.duration))
    some = np.isfinite(samples.feed)
    assert len(set(run[some])) > 1
    assert samples.feed[some] == pytest.approx(case.feed, rel=1e-5)
    # the table of tools says when each comes: with the run that it is in
    lengths = trajectory.axis_path.tool_lengths
    assert len(samples.tools) == 2 and samples.tools[0, layout.FROM] == 0.0
    assert samples.tools[:, layout.LONGER] + machine.tool_length == pytest.approx([0.12, 0.1975])
    changed = int(np.flatnonzero(np.diff(lengths))[0]) + 1
    assert samples.tools[1, layout.FROM] == trajectory.starts[changed]
    # a joint moves the tip of the longer one as far as own kinematics have it
    q, most = samples.q[:: len(samples.q) // 500], 0.0
    for j in machine.rotary:
        moved = q.copy()
        moved[:, j] += 1e-6
        ends = [case.chain.forward(each, length)[0] for length in (0.12, 0.1975) for each in (q, moved)]
        ways = [np.linalg.norm(ends[1] - ends[0], axis=1), np.linalg.norm(ends[3] - ends[2], axis=1)]
        most = max(most, float(np.max(ways)) / 1e-6)
    assert samples.reach[1] == pytest.approx(most, rel=0.01)


def test_a_compliance_of_one_tool_is_not_taken_for_two(trunnion):
    _, trajectory, machine = trunnion
    with pytest.raises(UsageError, match=r"one compliance for tools of 120, 197.5 mm; .* measure tip"):
        Follower(trajectory, machine, compliance=1e-7 * np.eye(3))


def test_a_law_of_two_tools_is_the_same_from_its_file(trunnion, tmp_path):
    _, trajectory, machine = trunnion
    follower = Follower(trajectory, machine)
    follower.save(tmp_path / "two.law")
    assert np.array_equal(tp.Follower.load(tmp_path / "two.law").piece, follower.piece)
    assert follower.piece[layout.TOOLS] == 2.0
