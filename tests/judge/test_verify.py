"""The judge must pass a good motion and catch it broken in every way that matters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support import motions
from tests.support.growth import NEARLY_LINEAR, order_of_growth
from tests.support.tool_paths import toolpath_through
from toolpace.common.errors import UsageError, VerificationError
from toolpace.judge import verify, verify_plan
from toolpace.judge.tool import sheet_check, tool_table
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.reading import read_text
from toolpace.programs.reading.setup_file import setup_of_text, setup_text

UP = np.array([0.0, 0.0, 1.0])
POINTS = motions.set_points()
PROGRAM = motions.program()
PEAKS = motions.peaks(motions.set_points(dt=1e-5))
MACHINE = motions.with_limits(motions.machine(), **PEAKS)


def replan(**kinds):
    return motions.with_limits(MACHINE, **kinds)


def again(q, points=POINTS):
    """Set-points of other positions, with derivatives by differences and the tool from the machine."""
    q = np.ascontiguousarray(q)
    tip, axis = MACHINE.forward(q)
    return replace(points, q=q, tip=tip, axis=axis)


def moved_tip(tip, points=POINTS):
    """Set-points whose tip is elsewhere."""
    columns = list(MACHINE.rotary)
    q = MACHINE.joints_at(np.ascontiguousarray(tip), np.ascontiguousarray(points.q[:, columns]))
    return again(q, points)


def failed(points, machine=MACHINE, program=PROGRAM, **options):
    return {check.what for check in verify(points, machine, program, **options).findings}


def test_passes_a_good_motion_at_exactly_its_peaks():
    result = verify(POINTS, MACHINE, PROGRAM)
    assert result.ok, result.findings
    assert result.raise_if_failed() is result
    assert result.tip_deviation < 2e-6
    assert result.axis_deviation < 1e-5
    assert all(row[-1] == "ok" for row in result.rows())


@pytest.mark.parametrize("dt", [5e-4, 2e-3])
def test_passes_at_other_time_steps(dt):
    assert verify(motions.set_points(dt=dt), MACHINE, PROGRAM, dt=dt).ok


@pytest.mark.parametrize("spacing", [5e-5, 5e-3])
def test_passes_with_dense_and_with_coarse_blocks(spacing):
    tolerance = 2e-4 if spacing > 1e-3 else 1e-5
    points = motions.set_points(spacing=spacing)
    assert verify(points, MACHINE, motions.program(spacing=spacing), tip_tolerance=tolerance).ok


def test_passes_through_a_trajectory_by_its_sample():
    class Sampled:
        def sample(self, dt):
            return motions.set_points(dt=dt)

    assert verify(Sampled(), MACHINE, PROGRAM, dt=2e-3).ok


@pytest.mark.parametrize("kind", ["velocity", "acceleration", "jerk"])
@pytest.mark.parametrize("joint", range(5))
def test_catches_a_limit_exceeded_by_one_percent(kind, joint):
    lowered = PEAKS[kind].copy()
    lowered[joint] *= 0.99
    assert kind in failed(POINTS, replan(**{kind: lowered}))


@pytest.mark.parametrize("kind", ["velocity", "acceleration"])
@pytest.mark.parametrize("joint", range(5))
def test_catches_it_from_positions_alone(kind, joint):
    lowered = PEAKS[kind].copy()
    lowered[joint] *= 0.97
    honest = replace(POINTS, qd=POINTS.qd * 0.5, qdd=POINTS.qdd * 0.5, qddd=POINTS.qddd * 0.5)
    assert kind in failed(honest, replan(**{kind: lowered}))


def test_catches_a_tip_shifted_by_20_micrometres():
    found = failed(moved_tip(POINTS.tip + 20e-6 * UP))
    assert {"tip, set-points to program", "tip, program to set-points"} <= found
    measured = verify(moved_tip(POINTS.tip + 20e-6 * UP), MACHINE, PROGRAM)
    assert measured.tip_deviation == pytest.approx(20e-6, rel=0.05)


def test_passes_a_tip_shifted_within_the_tolerance():
    shifted = moved_tip(POINTS.tip + 8e-6 * UP)
    # Its derivatives are those of another motion by up to a percent, and the limits leave no room.
    others = {"velocity", "acceleration", "jerk", "velocity column", "acceleration column"}
    assert not failed(shifted) - others


def test_catches_a_tilted_axis():
    q = POINTS.q.copy()
    q[:, 3] += np.radians(0.08)
    columns = list(MACHINE.rotary)
    shifted = again(MACHINE.joints_at(np.ascontiguousarray(POINTS.tip), np.ascontiguousarray(q[:, columns])))
    found = verify(shifted, MACHINE, PROGRAM)
    assert found.axis_deviation == pytest.approx(np.radians(0.08), rel=0.05)
    assert "axis, set-points to program" in {check.what for check in found.findings}


def test_catches_a_corner_cut():
    corner = PROGRAM.tip + 0.0
    middle = len(corner) // 3
    spike = corner.copy()
    spike[middle] += [0.0, 0.0, 3e-5]
    found = failed(POINTS, program=replace(PROGRAM, tip=spike))
    assert {"tip, program to set-points", "tip, set-points to program"} == found


def test_catches_a_skipped_block():
    detour = np.insert(PROGRAM.tip, 30, PROGRAM.tip[30] + [0.0, 0.01, 0.0], axis=0)

    def insert(values):
        return np.insert(values, 30, values[30], axis=0)

    names = ("axis", "feed", "least_time", "block", "stop", "dwell", "rotary")
    program = replace(PROGRAM, tip=detour, **{name: insert(getattr(PROGRAM, name)) for name in names})
    result = verify(POINTS, MACHINE, program)
    assert "tip, program to set-points" in {check.what for check in result.findings}
    worst = next(check for check in result.findings if check.what == "tip, program to set-points")
    assert worst.value == pytest.approx(0.01, rel=0.1)
    assert abs(worst.block - 40) <= 1


def test_catches_a_motion_that_ends_early():
    half = int(np.searchsorted(POINTS.t, motions.Ramp(motions.LENGTHS[0]).duration)) + 1
    names = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block")
    cut = replace(POINTS, **{name: getattr(POINTS, name)[:half].copy() for name in names})
    assert {"tip, program to set-points"} <= failed(cut)


def test_catches_a_feed_exceeded_by_one_percent():
    assert failed(POINTS, program=motions.program(feed=0.0495)) == {"feed"}


def test_knows_the_feed_of_each_block():
    feed = PROGRAM.feed.copy()
    feed[60:70] *= 0.9
    result = verify(POINTS, MACHINE, replace(PROGRAM, feed=feed))
    (found,) = result.findings
    assert found.what == "feed"
    assert 68 <= found.block <= 81


def test_catches_a_least_time_broken_by_one_percent():
    free = np.full(len(PROGRAM), np.inf)
    s = motions.Ramp(motions.LENGTHS[0])
    taken = np.zeros(len(PROGRAM))
    taken[20:60] = 5e-4 / s.speed
    assert not failed(POINTS, program=replace(PROGRAM, feed=free, least_time=taken))
    assert failed(POINTS, program=replace(PROGRAM, feed=free, least_time=taken * 1.01)) == {"least time"}


@pytest.mark.parametrize("order", [0, 1, 2])
def test_catches_a_jump(order):
    """A jump in position, velocity or acceleration is too much of the next derivatives."""
    q = POINTS.q.copy()
    t = np.maximum(POINTS.t - 0.4003, 0.0)
    size = (1e-6, 1e-4, 0.05)[order]
    q[:, 0] += size * (t > 0) * t**order
    assert "jerk" in failed(again(q), program=None)


@pytest.mark.parametrize("name", ["t", "q", "qd", "qddd", "tip"])
def test_catches_a_nan(name):
    values = getattr(POINTS, name).copy()
    values[500] = np.nan
    result = verify(replace(POINTS, **{name: values}), MACHINE, PROGRAM)
    assert not result.ok
    with pytest.raises(VerificationError, match=f"set-point 500: {name}"):
        result.raise_if_failed()


def test_catches_time_reversed():
    names = ("q", "qd", "qdd", "qddd", "tip", "axis", "block")
    backwards = replace(POINTS, **{name: getattr(POINTS, name)[::-1].copy() for name in names})
    assert "tip, set-points to program" in failed(backwards)
    assert "time step" in failed(replace(POINTS, t=POINTS.t[::-1].copy()))


def test_catches_uneven_time():
    t = POINTS.t.copy()
    t[700:] += 1e-5
    assert failed(replace(POINTS, t=t)) == {"unevenness of the time step"}


def test_catches_a_moving_start_and_end():
    names = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block")
    cut = replace(POINTS, **{name: getattr(POINTS, name)[100:-100].copy() for name in names})
    assert {"rest at the start", "rest at the end"} <= failed(cut, program=None)


def test_catches_travel_exceeded():
    model = motions.with_limits(MACHINE)
    travel = MACHINE.travel.copy()
    travel[0] = -1.0, 0.05
    object.__setattr__(model, "travel", travel)
    (found,) = verify(POINTS, model, PROGRAM).findings
    assert (found.what, found.joint) == ("highest position", "X")


def test_catches_columns_that_are_not_derivatives():
    assert failed(replace(POINTS, qd=POINTS.qd * 0.99)) == {"velocity column", "acceleration column"}
    assert failed(replace(POINTS, qdd=POINTS.qdd * 0.99)) == {"acceleration column"}


def test_catches_a_tip_column_that_is_not_forward_kinematics():
    assert failed(replace(POINTS, tip=POINTS.tip + 1e-6 * UP)) == {"tip column"}


def test_catches_a_short_dwell_and_a_missed_stop():
    longer = PROGRAM.dwell * 1.1
    assert failed(POINTS, program=replace(PROGRAM, dwell=longer)) == {"dwell"}
    stop = PROGRAM.stop.copy()
    stop[50] = True
    assert failed(POINTS, program=replace(PROGRAM, stop=stop)) == {"stillness at stops"}


def test_error_is_one_line_with_place_and_figures():
    lowered = PEAKS["jerk"].copy()
    lowered[3] *= 0.5
    with pytest.raises(VerificationError) as caught:
        verify(POINTS, replan(jerk=lowered), PROGRAM).raise_if_failed()
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith("jerk of A at ")
    assert "block" in text
    assert "deg/s3, allowed at most 1432.39" in text


def test_judges_bare_limits_without_a_tool():
    bare = SetPoints(
        *(getattr(POINTS, name) for name in ("t", "q", "qd", "qdd", "qddd")),
        tip=np.zeros((0, 3)),
        axis=np.zeros((0, 3)),
        block=POINTS.block,
        joints=POINTS.joints,
    )
    assert verify(bare, MACHINE.limits).ok
    with pytest.raises(UsageError, match="5 joints"):
        verify(bare, Limits(1.0, 1.0, 1.0, ("a", "b")))


def test_cost_grows_in_proportion_to_set_points_and_blocks():
    """No set-point is compared with every block: only with those about where the one before it was found."""
    free = replan(**{kind: 1.01 * peak + 1.0 for kind, peak in PEAKS.items()})
    few, many = ((motions.set_points(dt=4e-4 / n), motions.program(spacing=8e-5 / n)) for n in (1, 8))
    assert order_of_growth(lambda given: verify(given[0], free, given[1]), few, many, 8.0) < NEARLY_LINEAR


@pytest.mark.parametrize("far", [1e-6, -1e-6])
def test_travel_has_no_slack(far):
    """A micrometre and a microradian beyond the travel are found, on either side, for each joint."""
    for joint in range(5):
        model = motions.with_limits(MACHINE)
        travel = MACHINE.travel.copy()
        q = POINTS.q[:, joint]
        travel[joint] = (q.min(), q.max() - far) if far > 0.0 else (q.min() - far, q.max())
        object.__setattr__(model, "travel", travel)
        (found,) = verify(POINTS, model, PROGRAM).findings
        name = "highest position" if far > 0.0 else "lowest position"
        assert (found.what, found.joint) == (name, MACHINE.joints[joint])
        travel[joint] = q.min(), q.max()
        assert verify(POINTS, model, PROGRAM).ok


def test_catches_joints_in_another_order():
    renamed = replace(POINTS, joints=(*POINTS.joints[1:], POINTS.joints[0]))
    assert failed(renamed) == {"joints"}


def test_catches_a_jerk_column_of_another_motion():
    for qddd in (0.0 * POINTS.qddd, -POINTS.qddd, POINTS.qddd[::-1].copy()):
        assert failed(replace(POINTS, qddd=qddd)) == {"jerk column"}


def test_catches_a_wrong_block():
    assert failed(replace(POINTS, block=POINTS.block + 1)) == {"block column"}
    block = POINTS.block.copy()
    block[700] += 2
    (found,) = verify(replace(POINTS, block=block), MACHINE, PROGRAM).findings
    assert found.time == POINTS.t[700] and "1 set-points" in found.note


def test_the_tolerance_is_that_tolerance():
    """Three thousandths above it fail, three below it pass: what is granted is a thousandth."""
    near = {"tip, set-points to program", "tip, program to set-points"}
    # blocks so short that their chords are the curve
    points, program = motions.set_points(spacing=5e-5), motions.program(spacing=5e-5)
    assert near <= failed(moved_tip(points.tip + 1.003 * 10e-6 * UP, points), program=program)
    assert not near & failed(moved_tip(points.tip + 0.997 * 10e-6 * UP, points), program=program)


def test_figures_of_a_motion_that_cannot_be_judged_are_not_looked_at():
    """What is no motion is said alone; one that is has its figures judged."""
    q = POINTS.q.copy()
    q[500] = np.nan
    result = verify_plan(replace(POINTS, q=q), MACHINE, PROGRAM, {}, 10e-6, 1e-3)
    assert [check.what for check in result.findings] == ["set-points"]
    with pytest.raises(KeyError):
        verify_plan(POINTS, MACHINE, PROGRAM, {}, 10e-6, 1e-3)


def test_a_program_of_one_move_is_held_against_its_sheet():
    path = toolpath_through([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]], [UP, UP])
    for length, good in ((MACHINE.tool_length, True), (MACHINE.tool_length + 1e-3, False)):
        sheet = tool_table(f"[tools.1]\nlength = {length * 1e3!r}\n")
        (check,) = sheet_check(MACHINE, path, sheet)
        assert check.ok == good and check.block == path.block[1]


def test_a_tool_without_a_length_on_the_sheet_is_as_long_as_the_machines_own():
    machine = Machine.load("xyzac-trunnion")
    own = machine.tool_length
    program = "T1 M6\nG43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X10 A10 F600\nT2 M6\nG43.4 H2\nX20\nM30\n"
    sheet = '[tools.1]\nlength = "50mm"\n[tools.2]\ndiameter = 6\n'
    setup = setup_of_text(sheet)
    path = read_text(program, machine, controller="fanuc", setup=setup)
    table = tool_table(sheet)
    assert table["1"] == 0.05 and np.isnan(table["2"]) and tool_table(setup_text(setup))["1"] == 0.05
    (check,) = sheet_check(machine, path, table)
    assert check.ok
    (check,) = sheet_check(machine, path, table | {"2": own + 0.01})
    assert not check.ok and check.value == pytest.approx(0.01)
    assert sheet_check(machine, path, tool_table("[tools.1]\ndiameter = 6\n")) == []
