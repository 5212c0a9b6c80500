"""The machine that an INI and its HAL files tell moves as the real LinuxCNC does with the very same files."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from testbed.linuxcnc.configuration import Configuration
from testbed.linuxcnc.patterns import Pattern
from testbed.linuxcnc.run import run_program
from testbed.linuxcnc.shipped import INSTALLED, rows
from toolpace.common.units import DEGREE, MILLIMETRE
from toolpace.machine.from_control import read_control
from toolpace.machine.machine import Machine

NEAR = 1e-9
"""[m], [rad]: at rest, LinuxCNC's joints are its kinematics' to the last digits."""
POSES, TOOL = 20, 80.0
"""How many poses; length of tool 1 [mm]."""


@dataclass(frozen=True)
class Case:
    """A module with figures of its pins, and what else HAL connects."""

    module: str
    letters: str
    limits_of: str
    """A built-in machine with the same joints, for their limits."""
    pins: dict[str, float] = field(default_factory=dict)
    tool_pin: str = ""
    switched: bool = True
    """Whether M428 starts holding the tip; else the module always does."""
    hal: tuple[str, ...] = ()


PIVOT = (
    "loadrt sum2 names=pivot\naddf pivot servo-thread\nsetp pivot.in0 212.5\n"
    "net length <= motion.tooloffset.z => pivot.in1\nnet pivot pivot.out => 5axiskins.pivot-length\n"
)
CASES = (
    Case(
        "xyzac-trt-kins sparm=identityfirst", "XYZAC", "xyzac-trunnion",
        {"x-rot-point": 3.0, "y-rot-point": -7.0, "z-rot-point": 11.0, "y-offset": 20.0, "z-offset": 10.0},
        "tool-offset",
    ),
    Case(
        "xyzbc-trt-kins sparm=identityfirst", "XYZBC", "xyzbc-trunnion",
        {"x-rot-point": 4.0, "y-rot-point": 6.0, "z-rot-point": -9.0, "x-offset": -20.0, "z-offset": -15.0},
        "tool-offset",
    ),
    Case(
        "xyzab_tdr_kins", "XYZAB", "xyzab-table",
        {"x-rot-point": 5.0, "y-rot-point": -8.0, "z-rot-point": 13.0, "x-offset": -20.0, "z-offset": -10.0},
        "tool-offset-z",
    ),
    Case("5axiskins coordinates=XYZBCW sparm=identityfirst", "XYZBCW", "xyzbc-head", hal=(PIVOT,)),
    Case("maxkins", "XYZABCUVW", "xyzbc-millturn", {"pivot-length": 130.0}, switched=False),
)  # fmt: skip


def _configuration(case: Case) -> Configuration:
    name = case.module.split()[0]
    pins = {f"{name}.{pin}": value for pin, value in case.pins.items()}
    tool_pin = f"{name}.{case.tool_pin}" if case.tool_pin else ""
    pattern = Pattern(case.module, tuple(case.letters), pins, tool_pin, case.switched)
    return Configuration(Machine.load(case.limits_of), pattern, tools={1: TOOL * MILLIMETRE})


def _program(case: Case, poses: np.ndarray, turning: tuple[str, str]) -> str:
    """A stop in each pose (n, 5) [mm, deg]."""
    start = ["G21 G90 G94 G61.1", *(["T1 M6", "G43 H1"] if case.switched else []), *(["M428"] if case.switched else [])]
    moves = [
        f"G1 X{x:.6f} Y{y:.6f} Z{z:.6f} {turning[0]}{a:.6f} {turning[1]}{b:.6f} F30000\nG4 P0.3"
        for x, y, z, a, b in poses
    ]
    return "\n".join([*start, *moves, *(["M429"] if case.switched else []), "M2", ""])


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    "case",
    [CASES[0], *(pytest.param(case, marks=pytest.mark.sweep) for case in CASES[1:])],
    ids=lambda case: case.module.split()[0],
)
def test_joints_of_the_real_kinematics_are_those_of_the_machine_that_was_read(case, tmp_path):
    configuration = _configuration(case)
    configuration.write(tmp_path)
    more = []
    for number, text in enumerate(case.hal):
        more.append(tmp_path / f"more_{number}.hal")
        more[-1].write_text(text)
    machine = read_control([tmp_path / "machine.ini", *more]).machine
    turning = tuple(sorted(machine.geometry.rotary_joints))
    random = np.random.default_rng(7)
    poses = np.column_stack([random.uniform(-60.0, 60.0, (POSES, 3)), random.uniform(-55.0, 55.0, (POSES, 2))]).round(6)
    # one more, so that another move begins after the last that counts
    program = _program(case, np.vstack([poses, np.zeros(5)]), turning)
    log = run_program(program, configuration, hal=case.hal)
    joints = log.of(machine.joints)
    numbers = [number for number, line in enumerate(program.splitlines(), 1) if line.startswith("G1")]
    # a move ends in the last cycle before the next begins, after its pause
    ends = np.array([int(np.flatnonzero(log.line == number)[0]) for number in numbers[1:]]) - 1
    # on a busy computer LinuxCNC may count a pause from before the move: the next then follows without a rest
    still = (joints[ends] == joints[ends - 1]).all(axis=1)
    assert still.sum() >= POSES - 5
    rests, poses = joints[ends[still]], poses[still]
    length = TOOL * MILLIMETRE if case.switched else 0.0
    tip, _ = machine.forward(rests, np.full(len(rests), length))
    order = [machine.joints.index(name) for name in turning]
    assert np.abs(tip - poses[:, :3] * MILLIMETRE).max() < NEAR
    assert np.abs(rests[:, order] - poses[:, 3:] * DEGREE).max() < NEAR
    # far from what the words are as joints: a machine without kinematics would not pass
    assert np.abs(rests[:, machine.linear] - tip).max() > 10 * MILLIMETRE


@pytest.mark.sweep
@pytest.mark.linuxcnc
def test_configurations_that_linuxcnc_ships_are_read_or_refused_with_a_reason():
    found = list(rows(INSTALLED))
    assert len(found) > 300 and sum(not row.refused for row in found) > 200
    five = {row.name.rpartition("/")[2]: row.kind for row in found if len(row.axes) == 5}
    assert five["xyzac-trt"] == five["xyzbc-trt"] == five["xyzab-tdr"] == "table-table"
    assert five["5axis"] == "head-head" and five["max5kins"] == "head-table"
    assert not [row.name for row in found if row.refused and "vismach/5axis" in row.name and "trsrn" not in row.name]


@pytest.mark.linuxcnc
def test_two_shipped_machines_are_those_that_were_typed_by_hand():
    """The built-in machines of LinuxCNC's simulations were typed from the same files, by another hand."""
    vismach = INSTALLED / "sim/axis/vismach/5axis"
    table = read_control([vismach / "table-rotary-tilting/xyzac-trt.ini"]).machine
    typed = Machine.load("linuxcnc-xyzac-trt")
    assert table.limits == typed.limits and table.joints == typed.joints
    assert (table.travel == typed.travel).all() and np.abs(table.geometry.frame - typed.geometry.frame).max() < 1e-15
    head = read_control([vismach / "bridgemill/5axis.ini"]).machine
    typed = Machine.load("linuxcnc-xyzbc-bridgemill")
    q = np.random.default_rng(3).uniform(-0.5, 0.5, (20, 5))
    columns = [typed.joints.index(name) for name in head.joints]
    tip, axis = head.forward(q, 0.1)
    # by hand, the tip of its tool of 100 mm is where the joints are zero; read, the nose is
    typed_tip, typed_axis = typed.forward(q[:, np.argsort(columns)])
    assert np.abs(tip - typed_tip + np.array([0, 0, 0.1])).max() < 1e-12 and np.abs(axis - typed_axis).max() < 1e-12
