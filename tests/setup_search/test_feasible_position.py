"""The nearest place within all travels, against looking at many places."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from testbed.curved_pass import curved_pass
from toolpace.common.errors import ReachError
from toolpace.machine.machine import Machine
from toolpace.setup_search.clamping import Clamping
from toolpace.setup_search.trial import MARGIN, centre_of, feasible_position, nearest_within

BOX = np.array([[-0.3, 0.3], [-0.3, 0.3], [-0.2, 0.4]])


def fits(clamping: Clamping, machine: Machine) -> bool:
    toolpath = curved_pass()
    try:
        clamping.on(machine, centre_of(toolpath)).choose_rotary(toolpath)
    except ReachError:
        return False
    return True


@pytest.mark.parametrize("seed", range(6))
def test_the_nearest_place_is_found_and_fits(seed):
    rng, machine, toolpath = np.random.default_rng(seed), Machine.load("xyzac-trunnion"), curved_pass()
    wish = Clamping(rng.uniform(-3, 3), rng.uniform(0, 0.8), 0.0, tuple(rng.uniform(-1, 1, 3) * [0.3, 0.3, 0.2]))
    wish = replace(wish, shift=(wish.shift[0], wish.shift[1], max(wish.shift[2], -0.2)))
    found = feasible_position(wish, machine, toolpath, centre_of(toolpath), BOX)
    assert found.fits and fits(found.clamping, machine)
    moved = np.abs(np.array(found.clamping.shift) - wish.shift)
    if moved.sum() > 1e-6:
        # a place that is nearer by a little more than the margin does not fit
        for share in (0.0, 0.5, 0.9):
            nearer = np.array(wish.shift) + share * (np.array(found.clamping.shift) - wish.shift)
            if (1.0 - share) * moved.sum() > 3.0 * MARGIN:
                assert not fits(replace(wish, shift=tuple(nearer)), machine)


def test_where_no_place_fits_it_says_by_how_much():
    machine = Machine.load("xyzac-trunnion")
    joints = {
        name: replace_travel(joint, (-0.01, 0.01)) if name == "X" else joint
        for name, joint in machine.file.joints.items()
    }
    import msgspec

    small = replace(machine, file=msgspec.structs.replace(machine.file, joints=joints))
    toolpath = curved_pass()
    found = feasible_position(Clamping(), small, toolpath, centre_of(toolpath), BOX)
    assert not found.fits
    # X has to go about 120 mm, so it is beyond by about 50 mm on either side where it is best
    assert 0.02 < found.shortfall < 0.08


def replace_travel(joint, travel):
    import msgspec

    return msgspec.structs.replace(joint, travel=travel)


@pytest.mark.parametrize("seed", range(10))
def test_the_linear_program_against_a_grid(seed):
    """Random affine joints: the place found is within, and no place of a fine grid that is within is nearer."""
    rng = np.random.default_rng(seed)
    base, ways = rng.normal(size=(30, 3)) * 0.1, np.eye(3) + rng.normal(size=(30, 3, 3)) * 0.2
    travel = np.array([[-0.3, 0.25], [-0.28, 0.3], [-0.3, 0.3]])
    box, wish = np.array([[-0.2, 0.2]] * 3), rng.uniform(-0.2, 0.2, 3)
    move, beyond = nearest_within(base, ways, travel, wish, box)
    grid = np.array(list(itertools.product(np.linspace(-0.2, 0.2, 21), repeat=3))) - wish
    q = base[None] + np.einsum("nij,kj->kni", ways, grid)
    within = ((q >= travel[:, 0] + MARGIN) & (q <= travel[:, 1] - MARGIN)).all(axis=(1, 2))
    assert ((wish + move >= box[:, 0] - 1e-9) & (wish + move <= box[:, 1] + 1e-9)).all()
    if beyond <= 1e-7:
        at = base + ways @ move
        assert (at >= travel[:, 0] + MARGIN - 1e-7).all() and (at <= travel[:, 1] - MARGIN + 1e-7).all()
        if within.any():
            assert np.abs(move).sum() <= np.abs(grid[within]).sum(axis=1).min() + 1e-9
    else:
        assert not within.any()


def test_rotary_joints_that_do_not_reach_fall_short_more_the_further_they_are():
    machine, toolpath = Machine.load("xyzac-trunnion"), curved_pass()
    short = [
        feasible_position(Clamping(0.0, tilt, 0.0), machine, toolpath, centre_of(toolpath), BOX).shortfall
        for tilt in np.radians([0.0, 110.0, 130.0])
    ]
    assert short[0] == 0.0 and 0.0 < short[1] < short[2]
