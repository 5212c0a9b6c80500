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
    zero = np.zeros((1, 5))
    turned = np.zeros((1, 5))
    turned[0, machine.joints.index("B")] = np.radians(45.0)
    at_rest = -machine.forward(zero)[0][0]
    moved = -Rotation.from_euler("y", 45.0, degrees=True).apply(machine.forward(turned)[0][0])
    assert (moved - at_rest) * 1e3 == pytest.approx([15 * np.sqrt(0.5), 0.0, -15 * (1 - np.sqrt(0.5))], abs=1e-9)


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
