"""The guard by itself: what it looks for between the nodes, and what it hands back."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.jets import path_of, straight
from tests.support.mesh_problems import small
from toolpace.kernels.motion import cubic_spline
from toolpace.laws.spline import SplineLaw
from toolpace.machine.limits import Limits
from toolpace.planning.endstate import AT_REST
from toolpace.planning.guarantee import GUARANTEE
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.dips import lowest_z, on_finer_mesh, without_dips
from toolpace.planning.optimal.ease import eased, within_guarantee
from toolpace.planning.optimal.guard import guarded
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.solve import start_from
from toolpace.planning.optimal.windows import solve_run
from toolpace.planning.peaks import Look
from toolpace.workers import UNTOLD, Workers

WORKERS = Workers()
LOOSE = Limits([1.0], [1e6], [1e12])
"""A line that is run at full speed from end to end: no law that is slower somewhere uses more of these."""


def meshed_and_solved(run, limits, cells):
    """A run on a mesh, and its law with the limits held at the nodes."""
    nodes, rough = first_mesh(run, limits, (0.0, 0.0), cells)
    meshed = MeshedRun.after_guess(run, limits, nodes, (AT_REST, AT_REST), rough)
    c = solve_run(meshed, start_from(meshed, rough.s, rough.z, 0.4), 1.0, WORKERS, UNTOLD)
    return meshed, SplineLaw(meshed.nodes, c, meshed.rest)


def with_a_dip(law, cell, left=0.02):
    """The law with z fallen, within a cell, to a third of what is left of it at both its nodes."""
    c = law.c.copy()
    c[cell + 1 : cell + 3] *= left
    return SplineLaw(law.nodes, c, law.rest)


@pytest.mark.parametrize("fixed", [False, True])
def test_a_cell_in_which_z_falls_far_is_solved_again(fixed):
    """It passes no limit: nothing but the look at dips sees that the motion crawls there."""
    meshed, law = meshed_and_solved(path_of(straight([1.0])).runs[0], LOOSE, 60)
    law = guarded(meshed, law, True, WORKERS)
    assert not law.dips().any() and len(law.nodes) == len(meshed.nodes)
    crawling = with_a_dip(law, 30)
    assert crawling.dips()[30] and meshed.look.peaks(crawling).used.max() <= GUARANTEE
    assert crawling.duration > 1.05 * law.duration
    found = guarded(meshed, crawling, fixed, WORKERS)
    assert not found.dips().any() and found.duration < 1.001 * law.duration
    assert Look(meshed.run, LOOSE, found.nodes).peaks(found).used.max() <= GUARANTEE
