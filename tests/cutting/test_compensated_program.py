"""A program aimed off by what its tool bends: the right way, by the right amount, and found right by the judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from tests.support.bending import PROGRAM
from toolpace.common.errors import PathError, UsageError
from toolpace.cutting import compensated_program as module

MACHINE = tp.Machine.load("xyzac-trunnion")
TOOL = tp.CuttingTool(
    tp.Bending.cantilever(4e-3, 40e-3, 580e9).compliance,
    tp.Cut(
        tp.Cutter(4e-3, 2, np.radians(30.0)),
        tp.Coefficients(800e6, 300e6, 200e6, 15e3, 12e3),
        tp.Engagement("down", 8e-3, 0.15e-3),
        300.0,
    ),
    blend=4e-3,
)


@pytest.fixture(scope="module")
def toolpath():
    return tp.read_text(PROGRAM, MACHINE, name="slot.nc")


@pytest.fixture(scope="module")
def aimed(toolpath):
    return tp.compensate_bending(toolpath, MACHINE, TOOL)


def at(aimed, x, y):
    """What it is aimed off by where the tip is programmed at x, y [m]."""
    tip = aimed.toolpath.tip
    return aimed.bending[np.argmin(np.linalg.norm(tip - [x, y, 0.0], axis=1))]


@pytest.mark.sweep
def test_along_a_straight_line_it_is_the_force_at_the_feed(aimed):
    """In the middle of the first line: ahead is x, left is y, at the feed of the program; by hand."""
    forces = tp.CuttingForces(TOOL.cut).feed_forward(np.array([0.025 / (2 * 300.0)]))[0]
    right = TOOL.compliance @ forces
    np.testing.assert_allclose(at(aimed, 0.02, 0.0), right, rtol=2e-3)
    # along y ahead is y, and left is -x
    np.testing.assert_allclose(at(aimed, 0.04, 0.015), TOOL.compliance @ forces[[1, 0, 2]] * [-1, 1, 1], rtol=2e-3)
    assert right[1] > 40e-6 and aimed.largest < 1.5 * np.linalg.norm(right)


def test_the_tool_stands_where_the_bent_tip_is_right(aimed):
    points = aimed.trajectory.sample(1e-3)
    k = np.argmin(np.linalg.norm(points.tip - [0.02, 0.0, 0.0], axis=1))
    bent = points.tip[k] + at(aimed, 0.02, 0.0)
    assert abs(bent[1]) < 10e-6 and abs(bent[2]) < 10e-6 and abs(points.tip[k][1]) > 40e-6


def test_rapids_and_plunges_bend_nothing(aimed, toolpath):
    stations = aimed.toolpath
    far = stations.tip[:, 2] > TOOL.blend
    assert far.sum() > 3 and not aimed.bending[far].any()
    assert stations.rapid.any() and toolpath.rapid.any()


def test_the_judge_finds_the_bent_tip_on_the_program(aimed, toolpath):
    found = tp.verify(aimed.trajectory, MACHINE, toolpath, tool=TOOL)
    assert found.ok and found.tip_deviation <= 10e-6
    assert found.bending == pytest.approx(aimed.largest, abs=1e-6)


def test_a_stiff_tool_or_a_softer_one_would_miss(aimed, toolpath):
    for tool in (None, replace(TOOL, compliance=1.5 * TOOL.compliance), replace(TOOL, force="peak")):
        found = tp.verify(aimed.trajectory, MACHINE, toolpath, tool=tool)
        assert not found.ok and any(check.what.startswith("tip") for check in found.findings)


def test_as_planned_the_bent_tool_misses(toolpath):
    plain = tp.plan(tp.Path.fit(toolpath, machine=MACHINE), MACHINE)
    assert tp.verify(plain, MACHINE, toolpath).ok
    found = tp.verify(plain, MACHINE, toolpath, tool=TOOL)
    assert not found.ok and found.tip_deviation > 40e-6


def test_it_converges_to_a_micrometre_and_says_so(aimed):
    assert aimed.change <= 1e-6 and aimed.rounds >= 1
    assert repr(aimed).startswith("<BendingCompensation by at most 0.0") and len(repr(aimed)) <= 120


def test_the_path_has_the_blocks_of_the_program(aimed, toolpath):
    """Ways whose bent tip would exceed the feed have several blocks, with feeds up to 5 % lower (corners)."""
    entries = np.concatenate([run.entry for run in aimed.path.runs])
    assert (np.diff(entries) >= 0).all() and entries[-1] == len(toolpath) - 1
    np.testing.assert_array_equal(np.unique(entries), np.arange(1, len(toolpath)))
    for run in aimed.path.runs:
        np.testing.assert_array_equal(run.block, toolpath.block[run.entry])
        fed = np.isfinite(toolpath.feed[run.entry])
        share = run.feed[fed] / toolpath.feed[run.entry][fed]
        assert (share <= 1.0).all() and (share > 0.95).all() and (share == 1.0).any()
        assert not np.isfinite(run.feed[~fed]).any()


@pytest.mark.parametrize(("x", "y"), [(slice(None), 0.0), (0.04, slice(None))])
def test_the_bent_tip_keeps_the_feed(aimed, x, y):
    """By differences of set-points on the first and the second line, bent by what holds there: 25 mm/s, and 0.02 %."""
    along = 0 if y == 0.0 else 1
    stations, points = aimed.toolpath, aimed.trajectory.sample(1e-3)
    on = (np.abs(stations.tip[:, 2]) < 1e-12) & (np.abs(stations.tip[:, 1 - along] - (y, x)[along]) < 1e-12)
    line = np.flatnonzero(on)[np.argsort(stations.tip[on, along], kind="stable")]
    assert len(line) > 100
    cut = points.block == stations.block[line[len(line) // 2]]
    tip = points.tip[cut]
    bent = tip
    for _ in range(4):
        bent = tip + np.stack(
            [np.interp(bent[:, along], stations.tip[line, along], aimed.bending[line, k]) for k in range(3)], axis=1
        )
    speed = np.linalg.norm(np.diff(bent, axis=0), axis=1) / 1e-3
    assert 0.025 * 0.9999 < speed.max() <= 0.025 * 1.0002


def test_the_blocks_of_a_path_that_nothing_bends_are_those_of_the_program(toolpath):
    """Where the tool is as good as stiff, there is one block for each way, with the feed of the program."""
    stiff = tp.compensate_bending(toolpath, MACHINE, replace(TOOL, compliance=1e-6 * TOOL.compliance))
    for run in stiff.path.runs:
        assert (np.diff(run.entry) > 0).all()
        np.testing.assert_array_equal(run.feed, toolpath.feed[run.entry])
        np.testing.assert_array_equal(run.block, toolpath.block[run.entry])


def test_the_dwell_of_the_program_is_kept(aimed):
    assert aimed.trajectory.axis_path.runs[-2].dwell == 0.1


def test_slopes_of_the_shift_are_those_of_the_blend(aimed):
    step = np.linalg.norm(np.diff(aimed.toolpath.tip, axis=0), axis=1)
    slope = np.linalg.norm(np.diff(aimed.bending, axis=0), axis=1)[step > 0.0] / step[step > 0.0]
    assert slope.max() <= 4.5 * aimed.largest * 1.2 / TOOL.blend


def test_forces_over_time_bend_about_what_it_is_aimed_off_by(aimed):
    """Simulated: the tip of the straight line swings with the teeth about the place where it was programmed."""
    forces = tp.CuttingForces(TOOL.cut).over_time(np.linspace(0.0, 1.0 / 300.0, 3000, endpoint=False), 0.025)
    swing = tp.Bending(TOOL.compliance).deflection(forces, MACHINE, np.zeros(5), "tool") - at(aimed, 0.02, 0.0)
    assert np.abs(swing.mean(axis=0)).max() < 0.5e-6 and swing[:, 1].max() - swing[:, 1].min() > 10e-6


@pytest.mark.parametrize("name", ["xyzbc-head", "xyzac-head"])
def test_tools_in_heads_and_cutter_location_data(name):
    """Tool axes in place of rotary joints, a spring that is softer one way than the other, and tilted tools."""
    machine = tp.Machine.load(name)
    u = np.linspace(0.0, 1.0, 30)
    axis = np.stack([0.3 * u, 0.1 - 0.1 * u, np.ones(30)], axis=1)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    table = np.column_stack([40.0 * u, 8.0 * np.sin(3.0 * u), 2.0 * u, axis, np.full(30, 1500.0)])
    rows = [",".join(f"{each:.6f}" for each in row) for row in table]
    toolpath = tp.read_text(
        "x [mm],y [mm],z [mm],i,j,k,feed [mm/min]\n" + "\n".join(rows) + "\n", machine, dialect="csv"
    )
    tool = replace(TOOL, compliance=np.diag([3e-6, 1e-6, 1e-8]))
    found = tp.compensate_bending(toolpath, machine, tool)
    judged = tp.verify(found.trajectory, machine, toolpath, tool=tool)
    assert judged.ok and judged.bending > 20e-6
    assert not tp.verify(found.trajectory, machine, toolpath, tool=TOOL).ok


def test_other_tools_and_named_operations(toolpath):
    only = replace(TOOL, only=("1",))
    cut = module.cut_of_way(only, toolpath)
    np.testing.assert_array_equal(cut >= 0, module.cut_of_way(TOOL, toolpath) >= 0)
    with pytest.raises(UsageError, match=r"slot.nc has no tool '2'; .*1"):
        module.cut_of_way(replace(TOOL, only=("2",)), toolpath)
    unnamed = replace(toolpath, operations=tuple(replace(each, tool="") for each in toolpath.operations))
    with pytest.raises(UsageError, match=r"slot.nc has no tool '1'; it names no tools: leave that out"):
        module.cut_of_way(only, unnamed)
    with pytest.raises(UsageError, match="has no operation 'FINISH'"):
        module.cut_of_way(replace(TOOL, operations={"FINISH": TOOL.cut}), toolpath)
    name = toolpath.operations[int(toolpath.operation[-3])].name
    with pytest.raises(UsageError, match=r"nothing of slot\.nc cuts"):
        module.cut_of_way(replace(TOOL, operations={name: None}), toolpath)
    assert set(module.cut_of_way(replace(TOOL, operations={name: TOOL.cut}), toolpath)) == {-1, 1}


def test_what_cannot_be_aimed_off_is_one_error(toolpath, monkeypatch):
    with pytest.raises(UsageError, match="have no feed"):
        tp.compensate_bending(tp.apply_feed(toolpath, "none"), MACHINE, TOOL)
    with pytest.raises(UsageError, match=r"bends by .* in block \d+, and 0.05 of its blend"):
        tp.compensate_bending(toolpath, MACHINE, replace(TOOL, compliance=10.0 * TOOL.compliance))
    with pytest.raises(UsageError, match=r"set-points are .* apart"):
        module.refuse_coarse(toolpath, TOOL, 0.1)
    module.refuse_coarse(toolpath, TOOL, 0.01)
    swing = iter(range(100))
    monkeypatch.setattr(
        module,
        "predicted_bending",
        lambda stations, *rest: np.full((len(stations.way), 3), 1e-5 * ((next(swing) + 1) % 2)),
    )
    monkeypatch.setattr(module, "MOST_ITERATIONS", 2)
    with pytest.raises(PathError, match=r"does not converge: after 2 iterations .* 17.3 um, and 1 um are enough"):
        tp.compensate_bending(toolpath, MACHINE, TOOL)


def test_what_swings_for_ever_is_met_half_way(toolpath, monkeypatch):
    """Bending that answers each shift by the opposite of it, about 10 micrometres: plain rounds would never end."""
    shifts = []
    shifted = module.Stations.shifted

    def told(stations, shift, kept):
        shifts.append(shift)
        return shifted(stations, shift, kept)

    monkeypatch.setattr(module.Stations, "shifted", told)
    monkeypatch.setattr(module, "predicted_bending", lambda *rest: 20e-6 + shifts[-1])
    aimed = tp.compensate_bending(toolpath, MACHINE, TOOL)
    np.testing.assert_allclose(aimed.bending, 10e-6, atol=1e-6)
    assert module.SETTLED < aimed.rounds < module.MOST_ITERATIONS


HEAD = "G21 G90 G17\nS18000 M3\nG0 X0 Y0 Z20 A0 C0\n"
PROGRAMS = {
    "pocket in lines": "G1 Z0 F4000\n" + "".join(f"X{40 * (k % 2 == 0)} Y{k}\nY{k + 1}\n" for k in range(8)),
    "back and forth on one line": "G1 Z0 F2000\nX20\nX0\nX20\nX0\n",
    "arcs": "G1 Z0 F2500\nG2 X20 Y0 I10 J0\nG3 X40 Y0 I10 J0\nG2 X0 Y0 I-20 J0\n",
    "ramps": "G1 X0 Y0 Z5 F2000\n" + "".join(f"X{30 * (k % 2 == 0)} Z{4 - k}\n" for k in range(4)),
    "holes, and a slot": "".join(f"G0 X{10 * k}\nZ2\nG1 Z-10 F500\nG0 Z2\n" for k in range(3)) + "G1 Z0 X40 F2000\n",
    "shorter than the blend": "G1 Z0 F1500\nX2\n",
    "inverse time": "G1 Z0 F2000\nG93\nX20 A10 F40\nX30 Y10 C30 F40\nX0 A0 C0 F30\nG94\n",
    "turns in place, in the cut": "G1 Z0 F2000\nX20\nC90\nX0\nA20\nY20\n",
}
LOPSIDED = replace(
    TOOL,
    compliance=np.diag([1e-6, 3e-6, 1e-8]),
    force="peak",
    cut=replace(TOOL.cut, cutter=replace(TOOL.cut.cutter, runout=3e-6)),
)


@pytest.mark.sweep
@pytest.mark.parametrize(("name", "tool"), list(zip(PROGRAMS, 4 * (TOOL, LOPSIDED))), ids=list(PROGRAMS))
def test_programs_of_every_kind_are_aimed_off_and_found_right(name, tool):
    toolpath = tp.read_text(f"{HEAD}{PROGRAMS[name]}G0 Z40\nM30\n", MACHINE)
    tool = replace(tool, blend=6e-3)
    aimed = tp.compensate_bending(toolpath, MACHINE, tool)
    found = tp.verify(aimed.trajectory, MACHINE, toolpath, tool=tool)
    assert found.ok, found.findings
    assert aimed.rounds <= 3 and found.bending == pytest.approx(aimed.largest, abs=2e-6) and aimed.largest > 30e-6
