"""Curves that are read as points: the tip keeps its tolerance to the curve, not only to the chords between them."""

import numpy as np
import pytest

import toolpace as tp
from testbed.true_tip.held import farthest

HEAD = "G21 G90 G94 G17 G54\n"
CIRCLE = HEAD + "G0 X10 Y0 Z0\nG3 X10 Y0 I-10 J0 F6000\nG1 X10.5\nM30\n"
RADIUS, TOLERANCE = 0.010, 2e-6


@pytest.fixture(scope="module")
def machine():
    return tp.Machine.load("xyzbc-head")


def test_a_bow_is_the_sagitta_of_the_chord(machine):
    toolpath = tp.read_text(CIRCLE, machine, name="circle.ngc")
    round_it = toolpath.block == 3
    chord = toolpath.way_length[round_it]
    sagitta = RADIUS - np.sqrt(RADIUS**2 - 0.25 * chord**2)
    np.testing.assert_allclose(toolpath.bow[round_it], sagitta, rtol=1e-6)
    assert sagitta.min() > 0.2e-6
    assert not toolpath.bow[~round_it].any()


def test_the_bow_of_joints_is_how_far_the_tip_is_from_its_chord(machine):
    toolpath = tp.read_text(HEAD + "G1 X0 Y0 Z0 B0 C0 F3000\nG1 X3 Y1 B2 C3\nM30\n", machine, name="joints.ngc")
    assert machine.joints == ("X", "Y", "Z", "C", "B")
    joints = np.array([[0.0, 0.0, 0.0, 0.0, 0.0], [3e-3, 1e-3, 0.0, np.radians(3.0), np.radians(2.0)]])
    share = np.linspace(0.0, 1.0, 100001)
    places = joints[0] + share[:, None] * (joints[1] - joints[0])
    tips = machine.forward(places)[0]
    ends = tips[np.searchsorted(share, np.linspace(0.0, 1.0, len(toolpath)))]
    at = np.minimum((share * (len(toolpath) - 1)).astype(int), len(toolpath) - 2)
    along = ends[at + 1] - ends[at]
    way = np.einsum("nd,nd->n", tips - ends[at], along) / np.einsum("nd,nd->n", along, along)
    off = np.linalg.norm(tips - ends[at] - way[:, None] * along, axis=1)
    most = [off[at == k].max() for k in range(len(toolpath) - 1)]
    np.testing.assert_allclose(toolpath.bow[1:], most, rtol=0.02)


@pytest.mark.sweep
def test_the_tip_keeps_its_tolerance_to_the_way_of_the_joints(machine):
    rng = np.random.default_rng(1)
    steps = rng.uniform(-1.0, 1.5, (15, 5)) * [2.0, 2.0, 1.0, 2.0, 1.0]
    words = np.cumsum(np.vstack([[0.0, 0.0, 40.0, 0.0, 0.0], steps]), axis=0).round(3)
    blocks = "".join("G1 X{:.3f} Y{:.3f} Z{:.3f} C{:.3f} B{:.3f} F9000\n".format(*word) for word in words)
    toolpath = tp.read_text(f"{HEAD}{blocks}M30\n", machine, name="joints.ngc")
    plan = tp.plan_program(toolpath, machine, tip_tolerance=TOLERANCE, effort="normal")
    joints = words * [1e-3, 1e-3, 1e-3, np.radians(1.0), np.radians(1.0)]
    share = np.linspace(0.0, 1.0, 400, endpoint=False)[None, :, None]
    between = joints[:-1, None] + share * np.diff(joints, axis=0)[:, None]
    way = machine.forward(np.vstack([between.reshape(-1, 5), joints[-1:]]))[0]
    tips = plan.trajectory.sample(1e-3).tip
    assert farthest(tips, way) < TOLERANCE
    assert tp.verify(plan.trajectory.sample(1e-3), machine, toolpath, TOLERANCE).ok


def test_the_judge_counts_from_the_curve(machine):
    toolpath = tp.read_text(CIRCLE, machine, name="circle.ngc")
    plan = tp.plan_program(toolpath, machine, tip_tolerance=2e-6, effort="low")
    said = tp.verify(plan.trajectory.sample(1e-3), machine, toolpath, 2e-6)
    assert said.ok
    # the chords are nearer than the circle: what is just within the tolerance of them alone is refused
    narrow = said.tip_deviation * 1.001
    found = tp.verify(plan.trajectory.sample(1e-3), machine, toolpath, narrow)
    assert not found.ok
    assert "tip" in str(found)
