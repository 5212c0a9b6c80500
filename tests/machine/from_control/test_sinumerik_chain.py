"""Vector chains of a Sinumerik against the manual's sums, with any vectors, inclined axes and shifted positions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpace.machine.from_control import read_control

AXES = """N10240 $MN_SCALING_SYSTEM_IS_METRIC=1
N10000 $MN_AXCONF_MACHAX_NAME_TAB[0]="X1"
N10000 $MN_AXCONF_MACHAX_NAME_TAB[1]="Y1"
N10000 $MN_AXCONF_MACHAX_NAME_TAB[2]="Z1"
N10000 $MN_AXCONF_MACHAX_NAME_TAB[3]="B1"
N10000 $MN_AXCONF_MACHAX_NAME_TAB[4]="C1"
"""
TYPES = {"T": 24, "P": 40, "M": 56}
VECTORS = {
    "T": {"I1": "PART_OFFSET", "I2": "JOINT_OFFSET", "I3": "BASE_TOOL"},
    "P": {"I2": "BASE_TOOL", "I3": "JOINT_OFFSET", "I4": "PART_OFFSET"},
    "M": {"I1": "JOINT_OFFSET", "I2": "BASE_TOOL", "I3": "JOINT_OFFSET_PART", "I4": "PART_OFFSET"},
}
SAME = 1e-9
"""[mm]"""


def _tip(kind, vectors, axes, m, angles, t):
    """(3,) the tip, and (3,) the tool axis, by the sums in W1 and in the checklist of CYCLE800.

    axes: (2, 3) directions; angles: (2,) from the start [rad]; t: (3,) from the tip to the adapter.
    """
    v = {name: vectors.get(name, np.zeros(3)) for name in ("I1", "I2", "I3", "I4")}
    first, second = (Rotation.from_rotvec(a * u / np.linalg.norm(u)) for a, u in zip(angles, axes))
    up = np.array([0.0, 0.0, 1.0])
    if kind == "T":
        return m - v["I1"] - first.apply(v["I2"] + second.apply(v["I3"] + t)), first.apply(second.apply(up))
    if kind == "P":
        on_first = first.inv().apply(m - t - v["I2"])
        return second.inv().apply(on_first - v["I3"]) - v["I4"], second.inv().apply(first.inv().apply(up))
    head = m - v["I1"] - first.apply(v["I2"] + t)
    return second.inv().apply(head - v["I3"]) - v["I4"], second.inv().apply(first.apply(up))


def _lines(kind, vectors, axes, starts, signs):
    lines = [f"$MC_TRAFO_TYPE_1={TYPES[kind]}"]
    for name, datum in VECTORS[kind].items():
        lines += [f"$MC_TRAFO5_{datum}_1[{k}]={float(vectors[name][k])!r}" for k in range(3)]
    for place, axis in enumerate(axes):
        lines += [f"$MC_TRAFO5_AXIS{place + 1}_1[{k}]={float(signs[place] * axis[k])!r}" for k in range(3)]
        lines.append(f"$MC_TRAFO5_ROT_SIGN_IS_PLUS_1[{place}]={int(signs[place] > 0)}")
        lines.append(f"$MC_TRAFO5_ROT_AX_OFFSET_1[{place}]={starts[place]!r}")
    return lines


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", TYPES)
def test_tip_and_axis_are_the_manuals_sums(kind, seed, tmp_path):
    chance = np.random.default_rng(100 + seed)
    vectors = {name: chance.uniform(-300.0, 300.0, 3).round(4) for name in VECTORS[kind]}
    tilt, turn = chance.normal(size=3) * (1.0, 1.0, 0.2), chance.normal(size=3) * (0.1, 0.1, 1.0)
    axes = np.array([tilt, turn] if kind != "T" else [turn, tilt])
    starts, signs = chance.uniform(-90.0, 90.0, 2).round(3).tolist(), chance.choice([-1.0, 1.0], 2)
    names = ["B", "C"] if kind != "T" else ["C", "B"]
    lines = [AXES, *_lines(kind, vectors, axes, starts, signs)]
    if kind == "T":
        lines += ["$MC_TRAFO_AXES_IN_1[3]=5", "$MC_TRAFO_AXES_IN_1[4]=4"]
    (tmp_path / "mill.ini").write_text("\n".join(lines))
    length = 87.3
    machine = read_control([tmp_path / "mill.ini"]).machine.with_tool(length * 1e-3)
    columns = [machine.joints.index(name) for name in ("X", "Y", "Z", *names)]
    m, q = chance.uniform(-500.0, 500.0, (20, 3)), chance.uniform(-3.0, 3.0, (20, 2))
    joints = np.empty((20, 5))
    joints[:, columns] = np.hstack([m * 1e-3, q])
    tip, axis = machine.forward(joints)
    for k in range(20):
        wanted, up = _tip(kind, vectors, axes, m[k], q[k] - np.radians(starts), np.array([0.0, 0.0, length]))
        assert np.abs(tip[k] * 1e3 - wanted).max() < SAME * 1e3
        assert np.abs(axis[k] - up).max() < SAME


def test_the_table_of_the_manuals_example_turns_about_plus_y(tmp_path):
    """W1, 4-3 (08/2005): a table B with I4 = (0, 0, 15) at 45 degrees moves its zero point by (10.607, 0, -4.393)."""
    text = AXES.replace("B1", "A1").replace("C1", "B1")
    text += "$TC_CARR7[1]=1\n$TC_CARR11[1]=1\n$TC_CARR20[1]=15\n$TC_CARR21[1]=A\n$TC_CARR22[1]=B\n"
    text += '$TC_CARR23[1]="P" ;$TC_CARR13 and 14 are not looked at\n'
    (tmp_path / "table.ini").write_text(text)
    machine = read_control([tmp_path / "table.ini"]).machine
    (tmp_path / "example.mpf").write_text(text[text.index("$TC_CARR") :])
    alone = read_control([tmp_path / "example.mpf"])
    assert alone.machine.kind == machine.kind and alone.machine.joints == machine.joints
    assert "velocity of A [deg/s]" in [each.what for each in alone.stand_ins]
    zero = np.zeros((1, 5))
    turned = np.zeros((1, 5))
    turned[0, machine.joints.index("B")] = np.radians(45.0)
    at_rest = -machine.forward(zero)[0][0]
    moved = -Rotation.from_euler("y", 45.0, degrees=True).apply(machine.forward(turned)[0][0])
    assert (moved - at_rest) * 1e3 == pytest.approx([15 * np.sqrt(0.5), 0.0, -15 * (1 - np.sqrt(0.5))], abs=1e-9)


HEADS = {
    "W1, 2-92": ({"I1": [-200.0, 0.0, 0.0], "I3": [-100.0, 0.0, 0.0]}, [[1, 0, 0], [-1, 0, 1]], "AB", "100, 0, 0"),
    "IM9, 581": ({"I2": [0.0, 172.0, 172.0], "I3": [0.0, 0.0, 93.8]}, [[0, 1, 0], [0, 1, 1]], "BC", "0, -172, -265.8"),
}


@pytest.mark.parametrize("passed_over", ["", "$TC_CARR18[1]=7\n"])
@pytest.mark.parametrize("example", HEADS)
def test_a_head_of_the_manuals_is_read_as_it_does_not_close(example, passed_over, tmp_path):
    """Function Manual W1, 08/2005, and IM9, 12/2017, head HEAD_2; I4 of a head is passed over (W1, 2-88)."""
    offsets, axes, names, closing = HEADS[example]
    vectors = {name: np.array(offset) for name, offset in offsets.items()}
    text = AXES.replace("B1", f"{names[0]}1").replace("C1", f"{names[1]}1")
    firsts = {"I1": 1, "I2": 4, "I3": 15}
    for first, vector in [(firsts[name], offset) for name, offset in offsets.items()] + [(7, axes[0]), (10, axes[1])]:
        text += "".join(f"$TC_CARR{first + k}[1]={part}\n" for k, part in enumerate(vector))
    text += f'$TC_CARR21[1]={names[0]}\n$TC_CARR22[1]={names[1]}\n$TC_CARR23[1]="T"\n' + passed_over
    (tmp_path / "head.ini").write_text(text)
    draft = read_control([tmp_path / "head.ini"])
    assert draft.machine.joints == ("X", "Y", "Z", *names)
    m, q = np.array([10.0, -20.0, 30.0]), np.array([0.7, -1.1])
    tip, axis = draft.machine.with_tool(0.25).forward(np.array([[*m * 1e-3, *q]]))
    wanted, up = _tip("T", vectors, np.array(axes, dtype=float), m, q, np.array([0.0, 0.0, 250.0]))
    assert np.abs(tip[0] * 1e3 - wanted).max() < SAME and np.abs(axis[0] - up).max() < SAME
    remarks = " ".join(draft.record.remarks)
    assert f"and ({closing}) would close the chain" in remarks
    assert ("$TC_CARR18[1] is not 0: the control passes it over" in remarks) == bool(passed_over)


def test_swivel_data_of_a_head_that_a_person_turns_are_not_read(tmp_path):
    """IM9, page 574: tens of $TC_CARR37 are of the first axis, hundreds of the second."""
    head = '$TC_CARR8[1]=1\n$TC_CARR11[1]=1\n$TC_CARR12[1]=1\n$TC_CARR35[1]="HEADB"\n$TC_CARR36[1]="HEADC"\n'
    table = '$TC_CARR8[2]=-1\n$TC_CARR12[2]=-1\n$TC_CARR23[2]="P"\n$TC_CARR35[2]="B"\n$TC_CARR36[2]="C"\n'
    for display in (110, 13, 4_200_101):
        text = f"{AXES}{head}$TC_CARR37[1]={display}\n"
        (tmp_path / "mill.ini").write_text(f"{text}{table}$TC_CARR37[2]=1000005")
        draft = read_control([tmp_path / "mill.ini"])
        assert draft.machine.kind == "table-table" and not any("number of" in each.what for each in draft.stand_ins)
        assert any(f"$TC_CARR37[1] = {display}: a person turns axes" in each for each in draft.record.remarks)
        (tmp_path / "mill.ini").write_text(text)
        assert any(each.what.startswith("axes B, C") for each in read_control([tmp_path / "mill.ini"]).stand_ins)


def test_fine_offsets_count_where_the_control_adds_them(tmp_path):
    text = AXES + "$TC_CARR7[1]=0\n$TC_CARR8[1]=-1\n$TC_CARR12[1]=-1\n$TC_CARR6[1]=-100\n$TC_CARR20[1]=100\n"
    text += '$TC_CARR46[1]=0.25\n$TC_CARR23[1]="P"\n$TC_CARR35[1]="B"\n$TC_CARR36[1]="C"\n'
    (tmp_path / "table.ini").write_text(text)
    draft = read_control([tmp_path / "table.ini"])
    assert draft.record.joints["B"]["point"].value == (0.0, 0.0, -100.0)
    assert any("is a fine offset: it counts with $SC_TOCARR_FINE" in remark for remark in draft.record.remarks)
    text = text.replace("$TC_CARR20[1]=100", "$TC_CARR20[1]=99.75") + "$SC_TOCARR_FINE_CORRECTION=TRUE\n"
    (tmp_path / "table.ini").write_text(text)
    point = read_control([tmp_path / "table.ini"]).record.joints["B"]["point"]
    assert point.value == (0.0, 0.0, -99.75) and "$TC_CARR44" not in point.origin and "$TC_CARR46[1]" in point.origin


def test_the_start_of_a_turn_has_a_fine_offset_and_that_of_a_transformation_is_an_assumption(tmp_path):
    """$TC_CARR64 is 40 behind $TC_CARR24; a turn of the first axis by both together is none of the vectors."""
    text = AXES + "$TC_CARR8[1]=-1\n$TC_CARR12[1]=-1\n$TC_CARR24[1]=10\n$TC_CARR64[1]=0.5\n"
    text += '$TC_CARR23[1]="P"\n$TC_CARR21[1]=B\n$TC_CARR22[1]=C\n'
    axes = {}
    for counts in (0, 1):
        (tmp_path / "table.ini").write_text(f"{text}$SC_TOCARR_FINE_CORRECTION={counts}\n")
        draft = read_control([tmp_path / "table.ini"])
        assert any("$TC_CARR64[1] is a fine offset" in each for each in draft.record.remarks) == (not counts)
        axes[counts] = np.array(draft.record.joints["C"]["direction"].vector)
    assert np.degrees(np.arccos(axes[0] @ axes[1])) == pytest.approx(0.5)
    assert np.degrees(np.arccos(-axes[1][2])) == pytest.approx(10.5)
    lines = ["$MC_TRAFO_TYPE_1=40", "$MC_TRAFO5_AXIS1_1[1]=-1", "$MC_TRAFO5_AXIS2_1[2]=-1"]
    (tmp_path / "mill.ini").write_text("\n".join([AXES, *lines, "$MC_TRAFO5_ROT_AX_OFFSET_1[0]=30"]))
    remarks = read_control([tmp_path / "mill.ini"]).record.remarks
    assert any("ROT_AX_OFFSET_1[0] = 30: turns of B count from there (assumption)" in each for each in remarks)


@pytest.mark.parametrize(
    ("lines", "wanted"),
    [
        (["$MC_TRAFO_TYPE_1=40", "$MC_TRAFO5_AXIS1_1[1]=-1", "$MC_TRAFO_AXES_IN_1[4]=0"], "workpiece < C < B < bed"),
        (['$TC_CARR23[1]="P"', "$TC_CARR9[1]=-1", "$TC_CARR21[1]=C"], "workpiece < C < A < bed"),
        (['$TC_CARR23[1]="T"', "$TC_CARR8[1]=1", "$TC_CARR21[1]=B"], "workpiece < C < bed > X > Y > Z > B > tool"),
        (['$TC_CARR23[1]="T"', "$TC_CARR9[1]=1", "$TC_CARR21[1]=C"], "> Z > C > A > tool"),
        (['$TC_CARR23[1]="P"', "$TC_CARR8[1]=-1", "$TC_CARR21[1]=C"], "workpiece < A < C < bed"),
        (['$TC_CARR23[1]="P"', "$TC_CARR9[1]=-1", "$TC_CARR21[1]=B"], "workpiece < B < A < bed"),
    ],
)
def test_a_machine_with_one_turning_axis_has_the_other_at_rest(lines, wanted, tmp_path):
    (tmp_path / "mill.ini").write_text(AXES + "\n".join(lines))
    draft = read_control([tmp_path / "mill.ini"])
    assert wanted in repr(draft.machine) and len(draft.record.held) == 1
