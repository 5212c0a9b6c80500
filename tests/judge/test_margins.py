"""What the judge grants beside limits and tolerances: rounding, and what a step can hide; and no more than that."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tests.support import motions
from toolpace.judge import verify
from toolpace.judge.motion import position_noise
from toolpace.judge.seen_motion import difference_beyond_rounding
from toolpace.machine.limits import Limits
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.tolerances import Tolerances

DT = 1e-3
POINTS = motions.set_points()
PROGRAM = motions.program()
MACHINE = motions.with_limits(motions.machine(), **motions.peaks(motions.set_points(dt=1e-5)))


def joint(t, q, qd=0.0, qdd=0.0, qddd=0.0):
    """Set-points of one joint; derivatives that are told by one number are that everywhere."""
    values = [np.broadcast_to(np.asarray(value, dtype=float), t.shape)[:, None].copy() for value in (q, qd, qdd, qddd)]
    return SetPoints(t, *values, np.zeros((0, 3)), np.zeros((0, 3)), np.ones(len(t), dtype=np.int64), ("X",))


def failed(points, machine=MACHINE, program=None):
    return {check.what: check for check in verify(points, machine, program).findings}


def with_short_end(n=9, share=0.3):
    """Times whose last step is shorter than the others."""
    t = np.arange(n) * DT
    return np.append(t, t[-1] + share * DT)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_shorter_last_step_shows_the_derivative_that_it_has(order):
    """A derivative of 1 that sets in so late that nothing but the difference with the short step shows all of it."""
    t = with_short_end()
    begin = t[-1 - order]
    q = np.maximum(t - begin, 0.0) ** order / (1.0, 2.0, 6.0)[order - 1]
    value, at = difference_beyond_rounding(q, t, order, DT, np.zeros(len(q)))
    assert value == pytest.approx(1.0, rel=1e-3) and at == len(t) - 1


@pytest.mark.parametrize(("speed", "wrong"), [(1.01, True), (0.99, False)])
def test_catches_a_velocity_that_is_passed_in_a_shorter_last_step_alone(speed, wrong):
    t = with_short_end()
    q = np.where(t == t[-1], speed * (t[-1] - t[-2]), 0.0)
    found = failed(joint(t, q), Limits([1.0], [1e9], [1e12], ("X",)))
    assert ("velocity" in found) == wrong
    assert not wrong or found["velocity"].time == t[-1]


@pytest.mark.parametrize(("over", "wrong"), [(1.0002, True), (1.00005, False)])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_limit_is_held_to_a_ten_thousandth_of_itself(order, over, wrong):
    """A power of time, whose difference of that order is its derivative exactly."""
    kind = ("velocity", "acceleration", "jerk")[order - 1]
    t = 0.01 * np.arange(60)
    limits = {name: [1e9] for name in ("velocity", "acceleration", "jerk")} | {kind: [1.0 / over]}
    found = failed(joint(t, t**order / (1.0, 2.0, 6.0)[order - 1]), Limits(**limits, joints=("X",)))
    assert (kind in found) == wrong


def test_position_noise_is_the_rounding_of_a_position_and_of_its_time():
    random = np.random.default_rng(1)
    for speed in (1e-3, 1.0, 50.0):
        t = np.append(0.0, random.uniform(0.0, 1e6, 50))
        # q = speed t, and another that comes back: the time that it is worked out at is off by half of its last place
        q = speed * t
        worked_out = max(abs(float(Fraction(float(a)) - Fraction(speed) * Fraction(float(b)))) for a, b in zip(q, t))
        of_time = speed * float(np.spacing(t.max())) / 2.0
        assert worked_out + of_time <= position_noise(float(q.max()), float(t.max()), speed)
        assert of_time <= position_noise(1.0, float(t.max()), speed)
    # of a joint within a metre at the start of time: four units in the last place of a metre, no more
    assert position_noise(0.9, 0.0, 1.0) <= 4.5 * np.finfo(float).eps


@pytest.mark.parametrize("column", ["tip", "axis"])
@pytest.mark.parametrize(("far", "wrong"), [(1.5e-8, True), (0.8e-8, False)])
def test_a_single_tool_column_is_held_to_forward_kinematics(column, far, wrong):
    for at in (0, 333, len(POINTS) - 1):
        told = getattr(POINTS, column).copy()
        told[at] += far * np.array([0.0, 0.6, 0.8])
        found = failed(replace(POINTS, **{column: told}))
        assert list(found) == ([f"{column} column"] if wrong else [])
        assert not wrong or found[f"{column} column"].time == POINTS.t[at]


@pytest.mark.parametrize(("share", "wrong"), [(1.05, True), (0.95, False)])
@pytest.mark.parametrize("column", ["velocity", "acceleration"])
def test_a_column_may_be_off_by_what_the_jerk_can_hide_in_a_step(column, share, wrong):
    """A joint that stands, and a column that says otherwise: J dt^2 / 12 of speed, J dt / 4 of acceleration."""
    jerk, t = 40.0, np.arange(200) * DT
    most = {"velocity": jerk * DT**2 / 12.0, "acceleration": jerk * DT / 4.0}
    told = {"velocity": "qd", "acceleration": "qdd"}
    points = joint(t, 0.0, **{told[column]: share * most[column]})
    assert list(failed(points, Limits([1.0], [2.0], [jerk], ("X",)))) == ([f"{column} column"] if wrong else [])


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5])
def test_a_column_of_accelerations_that_jump_is_right_where_jerk_has_no_limit(shift):
    """Full acceleration, then full deceleration: the jumps lie at set-points, or between them."""
    acceleration, n = 2.0, 100
    t = np.arange(2 * n + 12) * DT
    begin, half = (5.0 + shift) * DT, n * DT
    after = [np.maximum(t - begin - k * half, 0.0) for k in range(3)]
    weight = acceleration * np.array([1.0, -2.0, 1.0])
    q = sum(w * each**2 / 2.0 for w, each in zip(weight, after))
    qd = sum(w * each for w, each in zip(weight, after))
    since = (t - begin) / half
    up, down = (since > -1e-9) & (since < 1.0 - 1e-9), (since > 1.0 - 1e-9) & (since < 2.0 - 1e-9)
    ramp = up.astype(float) - down
    limits = Limits([1.0], [acceleration], [np.inf], ("X",))
    assert not failed(joint(t, q, qd, acceleration * ramp), limits)


@pytest.mark.parametrize("begin", [0.0, 5.0, 5.1, 5.5, 5.9])
def test_columns_of_velocities_that_jump_are_right_where_nothing_limits_acceleration(begin):
    """There and back at full speed: the acceleration at a set-point says nothing, the velocity still must fit."""
    n, speed = 50, 0.5
    t = np.arange(2 * n + 8) * DT
    since = (t - begin * DT) / (n * DT)
    q = speed * n * DT * np.clip(np.minimum(since, 2.0 - since), 0.0, None)
    up, down = (since > 1e-9) & (since < 1.0 - 1e-9), (since > 1.0 + 1e-9) & (since < 2.0 - 1e-9)
    qd = speed * (up.astype(float) - down)
    limits = Limits([1.0], [np.inf], [np.inf], ("X",))
    assert not failed(joint(t, q, qd, 0.0 * t), limits)
    found = verify(joint(t, q, qd, 0.0 * t), limits)
    assert [check.note for check in found.checks if check.what == "acceleration column"] == [
        "not judged: nothing limits acceleration nor jerk"
    ]
    assert "velocity column" in failed(joint(t, q, -qd, 0.0 * t), limits)


@pytest.mark.parametrize("period", [0.97, 1.0093, 1.05])
def test_a_jerk_that_swings_once_a_step_is_known_by_its_velocities(period):
    """Seen once a step, the phase creeps on, and the column shows one side of the swing for long."""
    t, swing = np.arange(2000) * DT, 10.0
    w = 2.0 * np.pi / (period * DT)
    of_swing = (-swing / w**3 * np.sin(w * t), -swing / w**2 * np.cos(w * t), swing / w * np.sin(w * t))
    limits = Limits([1.0], [2.0], [100.0], ("X",))
    jerk = swing * np.cos(w * t)
    assert "jerk column" not in failed(joint(t, *of_swing, jerk), limits)
    # the same column beside a motion that does not swing so
    assert "jerk column" in failed(joint(t, 0.0, 0.0, 0.0, jerk), limits)
    calm = tuple(0.2 * each for each in of_swing)
    assert "jerk column" in failed(joint(t, *calm, jerk), limits)


@pytest.mark.parametrize("count", [1, 40])
@pytest.mark.parametrize("lasts", [0.01, 0.03, 0.1, 0.25, 0.5])
def test_a_swing_of_the_jerk_that_is_over_within_a_step_is_no_false_column(lasts, count):
    """From rest to a feed so slow, and back, that no set-point shows the acceleration, and some show all of the jerk:
    the first always, where the motion begins with it."""
    jerk, half, n = 50.0, 0.5 * lasts * DT, 1000
    random = np.random.default_rng(round(1e3 * lasts))
    begins = DT * np.append(0.0, np.sort(random.uniform(1.0, n - 3.0, 2 * count - 1)))
    t = np.arange(n) * DT
    q, qd, qdd, qddd = np.zeros((4, n))
    for begin, way in zip(begins, np.tile([jerk, -jerk], count)):
        for weight, since in zip((way, -2.0 * way, way), (t - begin, t - begin - half, t - begin - 2.0 * half)):
            after = np.maximum(since, 0.0)
            q += weight * after**3 / 6.0
            qd += weight * after**2 / 2.0
            qdd += weight * after
            qddd += weight * (since >= 0.0)
    limits = Limits([1.0], [2.0], [100.0], ("X",))
    assert qddd[0] == jerk and "jerk column" not in failed(joint(t, q, qd, qdd, qddd), limits)
    # where velocities show no swing, a column that tells of eight is another's
    told = np.zeros(n)
    told[100:300:25] = jerk
    assert "jerk column" in failed(joint(t, 0.0, 0.0, 0.0, told), limits)


def test_what_a_column_is_off_by_has_its_unit_and_size():
    found = failed(replace(POINTS, qd=0.99 * POINTS.qd))
    for what, per in (("velocity column", ""), ("acceleration column", "/s")):
        linear = found[what].joint in "XYZ"
        assert found[what].unit == ("m" if linear else "rad") + per
    found = failed(replace(POINTS, qddd=0.0 * POINTS.qddd))["jerk column"]
    peak = MACHINE.limits.jerk[MACHINE.joints.index(found.joint)]
    assert 0.01 * peak < found.value <= peak and found.limit < found.value


@pytest.mark.parametrize("end", ["start", "end"])
def test_rest_is_asked_of_positions_and_of_velocities_by_themselves(end):
    """A joint that moves at its ends while its velocity says rest, and one that stands while it says motion."""
    t = np.arange(50) * DT
    limits = Limits([1.0], [1e9], [1.0], ("X",))
    place = 0 if end == "start" else -1
    moving, told = np.zeros(len(t)), np.zeros(len(t))
    moving[place], told[place] = 1e-5, 0.01
    assert f"rest at the {end}" in failed(joint(t, moving), limits)
    assert f"rest at the {end}" in failed(joint(t, 0.0, told), limits)


@pytest.mark.parametrize(("over", "wrong"), [(1.003, True), (0.997, False)])
def test_the_tolerance_of_the_axis_is_that_tolerance(over, wrong):
    """What is granted beside it is a thousandth, as for the tip."""
    points, program = motions.set_points(spacing=5e-5), motions.program(spacing=5e-5)
    # each axis leans to the side of the way that it turns
    side = np.cross(program.axis, np.gradient(program.axis, axis=0))
    side /= np.linalg.norm(side, axis=1)[:, None]
    turned = np.cos(over * 1e-3) * program.axis + np.sin(over * 1e-3) * side
    found = set(failed(points, program=replace(program, axis=turned, rotary=None, rotary_joints=())))
    assert found == ({"axis, set-points to program", "axis, program to set-points"} if wrong else set())


@pytest.mark.parametrize(("over", "wrong"), [(1.003, True), (1.0, False)])
def test_each_block_has_all_of_its_own_tolerance(over, wrong):
    """A wide one beside a narrow one, used to the full: the matching grants it as the check does."""
    narrow, wide = 5e-6, 100e-6
    points, program = motions.set_points(spacing=5e-5), motions.program(spacing=5e-5)
    first, last = 200, 800
    tip, along = program.tip.copy(), np.linspace(0.0, np.pi, last - first)
    tip[first:last, 2] += over * wide * np.sin(along) ** 2
    tolerance = Tolerances(narrow, {f"{program.block[first]}-{program.block[last]}": wide})
    result = verify(points, MACHINE, replace(program, tip=tip), tip_tolerance=tolerance)
    assert any(check.what.startswith("tip") for check in result.findings) == wrong


@pytest.mark.parametrize("far", [0.0, 100.0, -100.0])
def test_rest_is_not_denied_for_the_rounding_of_a_position_far_off(far):
    """A double near 100 cannot say how far the jerk lets the joint go in the first step; near 0 it can."""
    t = np.arange(50) * 1e-5
    q = np.full(len(t), far)
    q[0] += np.spacing(100.0)
    limits = Limits([1.0], [1e9], [1.0], ("X",))
    assert ("rest at the start" in failed(joint(t, q), limits)) == (far == 0.0)
