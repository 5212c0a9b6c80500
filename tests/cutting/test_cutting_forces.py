"""The force model against closed forms, against integrals made here, and against the judge's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import toolpace as tp
from toolpace.common.errors import UsageError
from toolpace.judge.bent_tip import ForceTable

K = tp.Coefficients(800e6, 300e6, 200e6, 15e3, 12e3, 3e3)
CUTTER = tp.Cutter(diameter=8e-3, teeth=3, helix=np.radians(30.0))
CUT = tp.Cut(CUTTER, K, tp.Engagement("down", 5e-3, 1e-3), 200.0)


def cut(milling="down", **cutter):
    return replace(CUT, engagement=tp.Engagement(milling, 5e-3, 1e-3), cutter=replace(CUTTER, **cutter))


def mean(which, chip):
    return tp.CuttingForces(which).feed_forward(np.array([chip]))[0]


def test_a_slot_takes_the_mean_of_the_textbook():
    """Altintas: Fx = -N a (c Krc / 4 + Kre / pi), Fy = N a (c Ktc / 4 + Kte / pi), Fz = N a (c Kac / pi + Kae / 2);
    Fz here is away from the spindle, and our third component towards it."""
    n, a, c = 3, 5e-3, 5e-5
    right = [
        -n * a * (c * K.radial / 4 + K.radial_edge / np.pi),
        n * a * (c * K.tangential / 4 + K.tangential_edge / np.pi),
        -n * a * (c * K.axial / np.pi + K.axial_edge / 2),
    ]
    np.testing.assert_allclose(mean(cut("slot"), c), right, rtol=1e-12)


@pytest.mark.parametrize("milling", ["up", "down", "slot"])
def test_the_mean_is_the_integral_over_the_immersion(milling):
    c, a, radius = 4e-5, 5e-3, 4e-3
    wide = np.arccos((radius - 1e-3) / radius)
    start, end = {"up": (0.0, wide), "down": (np.pi - wide, np.pi), "slot": (0.0, np.pi)}[milling]

    def force(phi, component):
        h = c * np.sin(phi)
        t, r, z = K.tangential * h + K.tangential_edge, K.radial * h + K.radial_edge, K.axial * h + K.axial_edge
        return a * [-t * np.cos(phi) - r * np.sin(phi), t * np.sin(phi) - r * np.cos(phi), -z][component]

    right = [3 / (2 * np.pi) * quad(force, start, end, args=(k,))[0] for k in range(3)]
    np.testing.assert_allclose(mean(cut(milling), c), right, rtol=1e-10)


@pytest.mark.parametrize("helix", [-30.0, 0.0, 30.0, 55.0])
@pytest.mark.parametrize("milling", ["up", "down", "slot"])
def test_the_helix_spreads_the_force_and_keeps_its_mean(milling, helix):
    which = cut(milling, helix=np.radians(helix))
    angles = 3600 if helix else 36_000  # an edge without helix is in the material at once
    turn = tp.CuttingForces(which).at(np.linspace(0.0, 2.0 * np.pi, angles, endpoint=False), 5e-5)
    np.testing.assert_allclose(turn.mean(axis=0), mean(cut(milling), 5e-5), rtol=5e-4, atol=2e-3)


def test_climb_milling_pushes_the_tool_off_the_wall_on_its_right():
    ahead, left, along = mean(cut("down"), 5e-5)
    assert left > 0.0 and along < 0.0
    mirrored = mean(replace(cut("down"), clockwise=False), 5e-5)
    np.testing.assert_allclose(mirrored, [ahead, -left, along])


def test_teeth_pass_and_runout_makes_them_unlike():
    speed = 0.05
    turn, pitch = 1.0 / 200.0, 1.0 / 600.0
    t = np.linspace(0.0, turn, 300, endpoint=False)
    even, uneven = tp.CuttingForces(cut()), tp.CuttingForces(cut(runout=5e-6, runout_angle=0.4))
    np.testing.assert_allclose(even.over_time(t, speed), even.over_time(t + pitch, speed), atol=1e-6)
    np.testing.assert_allclose(uneven.over_time(t, speed), uneven.over_time(t + turn, speed), atol=1e-6)
    assert np.abs(uneven.over_time(t, speed) - uneven.over_time(t + pitch, speed)).max() > 5.0


def test_a_little_runout_leaves_the_mean_and_a_lot_leaves_one_tooth():
    """While every tooth cuts, what one leaves the next takes. With more runout than feed one tooth cuts all."""
    chip = 5e-5
    angle = np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False)
    slot = tp.Cut(replace(CUTTER, helix=0.0), replace(K, tangential_edge=0.0, radial_edge=0.0, axial_edge=0.0),
                  tp.Engagement("slot", 5e-3), 200.0)  # fmt: skip
    none = tp.CuttingForces(slot).at(angle, chip).mean(axis=0)
    some = tp.CuttingForces(replace(slot, cutter=replace(slot.cutter, runout=1e-6))).at(angle, chip).mean(axis=0)
    np.testing.assert_allclose(some, none, rtol=5e-3, atol=0.05)
    edged = replace(slot, coefficients=replace(K, axial=0.0, tangential=0.0, radial=0.0))
    lot = tp.CuttingForces(replace(edged, cutter=replace(edged.cutter, runout=4e-4))).at(angle, chip).mean(axis=0)
    single = tp.CuttingForces(replace(edged, cutter=replace(edged.cutter, teeth=1))).at(angle, chip).mean(axis=0)
    np.testing.assert_allclose(lot, single, rtol=0.02, atol=0.02)


def test_the_peak_points_as_the_mean_and_is_as_large_as_any():
    forces = tp.CuttingForces(cut())
    chip = np.array([0.0, 1e-5, 5e-5])
    peak, average = forces.feed_forward(chip, "peak"), forces.feed_forward(chip)
    turn = forces.at(np.linspace(0.0, 2.0 * np.pi, 7200), 5e-5)
    largest = np.hypot(turn[:, 0], turn[:, 1]).max()
    assert np.hypot(*peak[2, :2]) == pytest.approx(largest, rel=5e-3) and largest > np.hypot(*average[2, :2])
    np.testing.assert_allclose(np.cross(peak, average), 0.0, atol=0.05 * largest)
    np.testing.assert_array_equal(peak[0], 0.0)


def test_the_judges_peak_of_a_straight_tooth_is_where_it_leaves_the_thickest_chip():
    """Up milling with half the tool: at its end the chip is as thick as the feed per tooth, and all the edge cuts."""
    depth, chip = 5e-3, 5e-5
    one = replace(
        CUT, cutter=replace(CUTTER, teeth=1, helix=0.0), engagement=tp.Engagement("up", depth, 0.5 * CUTTER.diameter)
    )
    peak = ForceTable(one, "peak", chip).at(np.array([chip]))[0]
    largest = depth * np.hypot(K.tangential * chip + K.tangential_edge, K.radial * chip + K.radial_edge)
    assert np.hypot(*peak[:2]) == pytest.approx(largest, rel=1e-9)


def test_without_a_feed_there_is_no_force():
    forces = tp.CuttingForces(cut())
    np.testing.assert_array_equal(forces.at(np.linspace(0.0, 7.0, 50), 0.0), 0.0)
    np.testing.assert_array_equal(forces.feed_forward(np.zeros(4)), 0.0)
    np.testing.assert_allclose(forces.feed_per_tooth(0.06), 0.06 / 600.0)


@pytest.mark.parametrize("kind", ["mean", "peak"])
@pytest.mark.parametrize("runout", [0.0, 4e-6])
@pytest.mark.parametrize("milling", ["up", "slot"])
def test_the_judge_finds_the_same_forces_in_another_way(milling, runout, kind):
    which = replace(cut(milling, runout=runout, runout_angle=1.0), clockwise=milling == "up")
    chips = np.array([0.0, 5e-6, 2e-5, 6e-5])
    ours = tp.CuttingForces(which).feed_forward(chips, kind)
    np.testing.assert_allclose(ForceTable(which, kind, 6e-5).at(chips), ours, atol=6e-3 * np.abs(ours).max())


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: replace(CUT, engagement=tp.Engagement("climb", 5e-3, 1e-3)), "milling 'climb' is not known"),
        (lambda: replace(CUT, engagement=tp.Engagement("up", 5e-3)), "radial_depth is inf"),
        (lambda: replace(CUT, engagement=tp.Engagement("up", 5e-3, 9e-3)), "more than the diameter"),
        (lambda: replace(CUT, spindle_speed=0.0), "spindle_speed is 0"),
        (lambda: cut(helix=1.5), "helix"),
        (lambda: cut(runout=1e-3), "tenth of the diameter"),
        (lambda: cut(teeth=0), "teeth is 0"),
        (lambda: tp.CuttingForces(CUT).feed_forward(np.ones(1), "median"), "force 'median' is not known"),
    ],
)
def test_figures_that_no_cut_has_are_one_error(make, says):
    with pytest.raises(UsageError, match=says):
        make()
