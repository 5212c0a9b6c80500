"""What the two bounds are of: one of the plan's mesh, the other of every motion."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.machine.limits import Limits
from toolpace.motion.trajectory import Trajectory
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound.prove import prove
from toolpace.planning.planner import plan
from toolpace.results.write.plan_json import PlanRecord

BEST = 0.01 + np.sqrt(0.01**2 + 4.0)
"""[s] A straight line of length 1 at acceleration 1 and jerk 100, in closed form: ramps without coasting."""


@pytest.mark.parametrize("mesh", [8, 20, None])
def test_only_the_continuous_bound_speaks_of_every_motion(mesh):
    """On eight cells the bound of the mesh is above what is possible off it: it must not be told as more than that."""
    line = AxisPath.from_callable(lambda s, order: [s, 1 + 0 * s, 0 * s, 0 * s][order][:, None])
    trajectory = prove(plan(line, Limits([10.0], [1.0], [100.0]), mesh=mesh))
    assert 0.0 < trajectory.continuous_bound <= BEST + 1e-9
    assert trajectory.lower_bound <= trajectory.duration and np.isfinite(trajectory.gap)
    if mesh == 8:
        assert trajectory.lower_bound > BEST
    assert "on its mesh" in repr(trajectory)


def test_the_words_of_the_mesh_bound_name_the_mesh():
    assert "mesh" in (Trajectory.gap.__doc__ or "")
    assert "lower_bound_of" in PlanRecord.__struct_fields__
