"""Every array argument of a public function, with a call and the numbers that it is tried with."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np

import toolpace as tp
from tests.support.engagements import shoulder
from toolpace.programs.tool_figures import ToolFigures
from toolpace.programs.toolpath import ToolPath

MACHINE = tp.Machine.load("xyzac-trunnion")
LIMITS = tp.Limits([0.5, 0.5], [2.0, 2.0], [20.0, 20.0])
RNG = np.random.default_rng(5)


def f32(values: Any) -> np.ndarray:
    """The values with no more digits than a float of 32 bits has: those of all kinds are the same."""
    return np.asarray(values, dtype=np.float32).astype(float)


POSES = f32(RNG.uniform(-0.5, 0.5, (6, 5)))
TIPS, TURNS = f32(RNG.uniform(-0.1, 0.1, (6, 3))), f32(RNG.uniform(-0.4, 0.4, (6, 2)))
AXES = np.array(
    [[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, -0.6, 0.8], [0.6, 0.0, 0.8], [0.0, 0.28, 0.96], [0.0, 0.0, 1.0]]
)
AXES = AXES / np.linalg.norm(AXES, axis=1)[:, None]
AXIS_JETS = MACHINE.axis_jets(f32(RNG.uniform(-0.4, 0.4, (4, 6, 2))))
JETS = f32(RNG.uniform(-0.1, 0.1, (4, 6, 5)))
NAN_FOR_OWN = f32([0.15, 0.2, 0.25, 0.15, 0.1, 0.3])
LINES = np.arange(1.0, 7.0)
DENSE = tp.read_text(
    "G90 G21 G94 G1 X0 Y0 Z50 A0 C0 F2000\nX10 Y2 A5 C20\nX20 Y0 A10 C40\nX30 Y5 A5 C50\nM30\n", MACHINE
)
EXACT = tp.Path.arc([0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, feed=0.05)
WAYPOINTS = tp.AxisPath.from_waypoints([[0.0, 0.0], [0.5, 0.2], [1.0, 0.1]])
PLANNED = tp.plan(WAYPOINTS, LIMITS, mesh=60, bound=False)
ON_MACHINE = tp.plan(tp.Path.fit(DENSE, machine=MACHINE), MACHINE, bound=False)
POINTS = PLANNED.sample(0.05)
ON_TOOL = ON_MACHINE.sample(0.01)
CUT = tp.Cut(
    tp.Cutter(0.01, 2, math.radians(30.0)), tp.Coefficients(1.8e9, 6e8, 2e8, 2e4, 1e4),
    tp.Engagement("down", 0.003, 0.004), 200.0,
)  # fmt: skip
FORCES = tp.CuttingForces(CUT)
ENGAGED = tp.EngagedForces(
    shoulder(1e-3, 0.0, 1.0, slices=2, stations=len(LINES)), ToolFigures("flat", 0.01, teeth=2), CUT.coefficients, 200.0
)
BENDING = tp.Bending(np.diag([1e-7, 1e-7, 2e-8]))
KNOTS = np.array([0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0])
CONTROL = f32(RNG.uniform(0.0, 0.1, (5, 3)))
ZONE = tp.Zone("box", {"X": (-0.1, 0.1)})
HASTE = tp.SpeedWeights(np.linspace(0.0, 1.0, 6), np.stack([np.full(6, 0.5), np.zeros(6), np.zeros(6)]), 0.05, 5.0)
LINE = {
    "tip": f32(np.linspace([0.0, 0.0, 0.0], [0.05, 0.0, 0.0], 6)), "axis": np.tile([0.0, 0.0, 1.0], (6, 1)),
    "feed": np.full(6, 0.03125), "least_time": np.zeros(6), "block": LINES, "stop": np.arange(6) % 5 == 0,
    "dwell": np.zeros(6),
}  # fmt: skip


def line(**changes: Any) -> ToolPath:
    return ToolPath(**{**LINE, **changes})


def sine(**more: Any) -> tp.AxisPath:
    return tp.AxisPath.from_callable(lambda s, order: np.sin(s + 0.5 * np.pi * order)[:, None], **more)


def rated(continuous: Any, **more: Any) -> tuple[Any, ...]:
    return tp.torque_rows(lambda q, qd, qdd: qdd, 9.0, list("ABCDEF"), continuous=continuous, **more)


@dataclasses.dataclass(frozen=True)
class Case:
    """One argument of one function."""

    call: Callable[[Any], Any]
    clean: np.ndarray
    named: str
    """How a message calls it."""
    endless: bool = False
    """Whether infinity means something."""
    missing: bool = False
    """Whether nan means something."""
    optional: bool = False
    """Whether None means something."""
    any_width: bool = False
    """Whether it may have any number of columns."""


M = MACHINE
CASES: dict[str, Case] = {
    "Machine.forward: q": Case(M.forward, POSES, "q"),
    "Machine.forward: tool_length": Case(lambda x: M.forward(POSES, x), NAN_FOR_OWN, "tool_length", False, True, True),
    "Machine.axis_at: rotary": Case(M.axis_at, TURNS, "rotary"),
    "Machine.rotary_solutions: axis": Case(M.rotary_solutions, AXES, "axis"),
    "Machine.joints_at: tip": Case(lambda x: M.joints_at(x, TURNS), TIPS, "tip"),
    "Machine.joints_at: rotary": Case(lambda x: M.joints_at(TIPS, x), TURNS, "rotary"),
    "Machine.joints_at: tool_length": Case(
        lambda x: M.joints_at(TIPS, TURNS, x), NAN_FOR_OWN, "tool_length", False, True, True
    ),
    "Machine.linear_jets: tip": Case(lambda x: M.linear_jets(x, JETS[:, :, 3:]), JETS[:, :, :3], "tip"),
    "Machine.linear_jets: rotary": Case(lambda x: M.linear_jets(JETS[:, :, :3], x), JETS[:, :, 3:], "rotary"),
    "Machine.rotary_jets: axis": Case(lambda x: M.rotary_jets(x, TURNS), AXIS_JETS, "axis"),
    "Machine.rotary_jets: rotary": Case(lambda x: M.rotary_jets(AXIS_JETS, x), TURNS, "rotary"),
    "Machine.axis_jets: rotary": Case(M.axis_jets, JETS[:, :, 3:], "rotary"),
    "Machine.tip_lever: tip": Case(lambda x: M.tip_lever(x, TURNS), TIPS, "tip"),
    "Machine.tip_lever: rotary": Case(lambda x: M.tip_lever(TIPS, x), TURNS, "rotary"),
    "Machine.turn_between: axis": Case(M.turn_between, AXES, "axis"),
    "Machine.rotary_between: known": Case(
        lambda x: M.rotary_between(DENSE, x, M.choose_rotary(DENSE)), np.arange(float(len(DENSE))), "known"
    ),
    "Machine.rotary_between: rotary": Case(
        lambda x: M.rotary_between(DENSE, np.arange(len(DENSE)), x), f32(M.choose_rotary(DENSE)), "rotary"
    ),
    "Machine.check_travel: q": Case(lambda x: M.check_travel(x, LINES), 0.1 * POSES, "q", True, True),
    "Machine.check_travel: block": Case(lambda x: M.check_travel(0.1 * POSES, x), LINES, "block"),
    "Limits: velocity": Case(lambda x: tp.Limits(x, 1.0, 1.0), LINES, "velocity", True),
    "Limits: acceleration": Case(lambda x: tp.Limits(1.0, x, 1.0), LINES, "acceleration", True),
    "Limits: jerk": Case(lambda x: tp.Limits(1.0, 1.0, x), LINES, "jerk", True),
    "LimitCurve: corners": Case(tp.LimitCurve, np.stack([LINES - 1.0, 7.0 - LINES], axis=1), "limit over speed"),
    "torque_rows: most": Case(
        lambda x: [row.limit for row in tp.torque_rows(lambda q, qd, qdd: qdd, x, list("ABCDEF"))], LINES,
        "torques", True,
    ),
    "torque_rows: continuous": Case(
        lambda x: [repr(each.rating) for each in rated(x)], LINES, "torques", True, optional=True
    ),
    "torque_rows: window": Case(
        lambda x: [repr(each.rating) for each in rated(5.0, window=x)], LINES, "torques", True
    ),
    "SpeedProfile: place": Case(lambda x: tp.SpeedProfile(x, LINES, LINES % 2, ("a", "b")), f32(LINES), "place"),
    "SpeedProfile: speed": Case(lambda x: tp.SpeedProfile(LINES, x, LINES % 2, ("a", "b")), f32(LINES), "speed", True),
    "SpeedProfile: limit": Case(lambda x: tp.SpeedProfile(LINES, LINES, x, ("a", "b")), LINES % 2, "limit"),
    "ToolPath: rotary": Case(
        lambda x: line(rotary=x, rotary_joints=("A", "C")), np.zeros((6, 2)), "rotary", optional=True
    ),
    "ToolPath: rapid": Case(lambda x: line(rapid=x), np.arange(6) == 3, "rapid"),
    "ToolPath: operation": Case(lambda x: line(operation=x, operations=2 * (tp.Operation(),)), LINES // 4, "operation"),
    "ToolPath: tip_tolerance": Case(lambda x: line(tip_tolerance=x), LINES, "tip_tolerance", True, True),
    "ToolPath: axis_tolerance": Case(lambda x: line(axis_tolerance=x), LINES, "axis_tolerance", True, True),
    "ToolPath: normal": Case(lambda x: line(normal=x), AXES, "normal", True, True),
    "ToolPath: bow": Case(lambda x: line(bow=x), 1e-7 * LINES, "bow"),
    "ToolPath: numbered": Case(lambda x: line(numbered=x), np.stack([LINES, LINES], axis=1), "numbered"),
    "ToolPath: spindle": Case(lambda x: line(spindle=x), NAN_FOR_OWN, "spindle", True, True),
    "ToolPath.spindle_of: operation": Case(lambda x: line().spindle_of(x, LINES), LINES, "operation"),
    "ToolPath.spindle_of: block": Case(lambda x: line().spindle_of(LINES, x), LINES, "block"),
    "ToolPath: tool_length": Case(lambda x: line(tool_length=x), NAN_FOR_OWN, "tool_length", True, True),
    "AxisPath.from_waypoints: q": Case(tp.AxisPath.from_waypoints, 5.0 * TURNS, "q", any_width=True),
    "AxisPath.from_waypoints: s": Case(lambda x: tp.AxisPath.from_waypoints(POSES, s=x), LINES, "s", optional=True),
    "AxisPath.from_callable: breaks": Case(lambda x: sine(breaks=x), f32([0.25, 0.5, 0.75]), "breaks"),
    "AxisPath.from_callable: hints": Case(lambda x: sine(hints=x), f32([0.25, 0.5, 0.75]), "hints"),
    "Path.arc: centre": Case(lambda x: tp.Path.arc(x, [1, 0, 0], [0, 0, 1], 1.0), np.zeros(3), "centre"),
    "Path.arc: start": Case(lambda x: tp.Path.arc([0, 0, 0], x, [0, 0, 1], 1.0), np.array([1.0, 0.0, 0.0]), "start"),
    "Path.arc: normal": Case(lambda x: tp.Path.arc([0, 0, 0], [1, 0, 0], x, 1.0), np.array([0.0, 0.0, 1.0]), "normal"),
    "Path.from_bspline: knots": Case(lambda x: tp.Path.from_bspline(x, CONTROL, CONTROL + 0.1), KNOTS, "knots"),
    "Path.from_bspline: tip": Case(lambda x: tp.Path.from_bspline(KNOTS, x, CONTROL + 0.25), CONTROL, "tip"),
    "Path.from_bspline: axis_point": Case(
        lambda x: tp.Path.from_bspline(KNOTS, CONTROL, x), f32(CONTROL + 0.25), "axis_point"
    ),
    "Trajectory.at: t": Case(PLANNED.at, f32([0.1, 0.3, 0.2]), "time", True),
    "Trajectory.parameter: t": Case(PLANNED.parameter, f32([0.1, 0.3, 0.2]), "time", True),
    "Trajectory.run_at: t": Case(PLANNED.run_at, f32([0.1, 0.3, 0.2]), "time", True),
    "Trajectory.tip: t": Case(ON_MACHINE.tip, f32([0.1, 0.3, 0.2]), "time", True),
    "Bending: compliance": Case(tp.Bending, f32(np.diag([1e-7, 1e-7, 2e-8])), "compliance"),
    "Bending.deflection: force": Case(lambda x: BENDING.deflection(x, M, POSES), 100.0 * TIPS, "force"),
    "Bending.deflection: q": Case(lambda x: BENDING.deflection(100.0 * TIPS, M, x), POSES, "q"),
    "CuttingTool: compliance": Case(
        lambda x: tp.CuttingTool(x, CUT, 0.01), f32(np.diag([1e-7, 1e-7, 2e-8])), "compliance"
    ),
    "EngagedDeflection: way": Case(lambda x: tp.EngagedDeflection(x, TIPS, TIPS), np.arange(float(len(TIPS))), "way"),
    "EngagedDeflection: slope": Case(
        lambda x: tp.EngagedDeflection(np.arange(float(len(TIPS))), x, TIPS), 1.0 * TIPS, "slope"
    ),
    "EngagedDeflection: constant": Case(
        lambda x: tp.EngagedDeflection(np.arange(float(len(TIPS))), TIPS, x), 1.0 * TIPS, "constant"
    ),
    "CuttingForces.at: angle": Case(lambda x: FORCES.at(x, 1e-5), LINES, "angle"),
    "CuttingForces.over_time: t": Case(lambda x: FORCES.over_time(x, 0.02), LINES, "t"),
    "CuttingForces.feed_per_tooth: speed": Case(FORCES.feed_per_tooth, LINES, "speed"),
    "EngagedForces.chips_together: speed": Case(ENGAGED.chips_together, LINES, "speed"),
    "EngagedForces.loads: speed": Case(ENGAGED.loads, LINES, "speed"),
    "EngagedForces.loads: turning": Case(
        lambda x: ENGAGED.loads(LINES, x), f32(1e-3 * np.stack([LINES, LINES], axis=1)), "turning", optional=True
    ),
    "EngagedForces.over_turn: stations": Case(
        lambda x: ENGAGED.over_turn(x, LINES), np.arange(float(len(LINES))), "stations"
    ),
    "EngagedForces.over_turn: speed": Case(lambda x: ENGAGED.over_turn([0], x), LINES, "speed"),
    "EngagedForces.over_turn: turning": Case(
        lambda x: ENGAGED.over_turn([0], LINES, x),
        f32(1e-3 * np.stack([LINES, LINES], axis=1)),
        "turning",
        optional=True,
    ),
    "CuttingForces.feed_forward: chip": Case(FORCES.feed_forward, f32(1e-5 * LINES), "chip"),
    "Clamping.on: centre": Case(lambda x: tp.Clamping(0.5).on(M, x), f32([0.1, 0.2, 0.3]), "centre"),
    "Zone.entered: q": Case(lambda x: ZONE.entered(M.joints, x), POSES, "q"),
    "SpeedWeights: s": Case(lambda x: dataclasses.replace(HASTE, s=x), HASTE.s, "s"),
    "SpeedWeights: pace": Case(lambda x: dataclasses.replace(HASTE, pace=x), HASTE.pace, "pace"),
    "SpeedWeights.rows: breaks": Case(lambda x: HASTE.rows(x, 1.0), np.linspace(0.0, 1.0, 5), "breaks"),
    "deflection.project: tip": Case(lambda x: tp.deflection.project(EXACT, x), f32([0.09, 0.02, 0.01]), "tip"),
    "deflection.project: deflection": Case(
        lambda x: tp.deflection.project(EXACT, deflection=x), f32([0.09, 0.02, 0.01]), "tip"
    ),
    "deflection.force: target": Case(lambda x: tp.deflection.force(x, [0.0, 0.0, 0.0]), LINES[:3], "target"),
    "deflection.force: deflection": Case(lambda x: tp.deflection.force([0.0, 0.0, 0.0], x), LINES[:3], "deflection"),
    "deflection.potential: target": Case(lambda x: tp.deflection.potential(x, [0.0, 0.0, 0.0]), LINES[:3], "target"),
    "deflection.potential: deflection": Case(
        lambda x: tp.deflection.potential([0.0, 0.0, 0.0], x), LINES[:3], "deflection"
    ),
    "deflection.potential: velocity": Case(
        lambda x: tp.deflection.potential([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], velocity=(x, [0.0, 0.0, 0.0])), LINES[:3],
        "velocity",
    ),
    "deflection.deflected_pose: tip": Case(
        lambda x: tp.deflection.deflected_pose(ON_MACHINE, 0.3, x), f32(ON_MACHINE.tip(0.3)[0] + 1e-4), "tip"
    ),
    "deflection.deflected_pose: deflection": Case(
        lambda x: tp.deflection.deflected_pose(ON_MACHINE, 0.3, deflection=x), f32([1e-4, -2e-4, 3e-4]), "deflection"
    ),
    "deflection.deflected_pose: axis": Case(
        lambda x: tp.deflection.deflected_pose(ON_MACHINE, 0.3, ON_MACHINE.tip(0.3)[0], axis=x),
        f32(ON_MACHINE.tip(0.3)[1]), "axis", optional=True,
    ),
    "deflection.replan: tip": Case(lambda x: tp.replan(ON_MACHINE, 0.3, x), f32(ON_MACHINE.tip(0.3)[0] + 1e-5), "tip"),
    "deflection.replan: deflection": Case(
        lambda x: tp.replan(ON_MACHINE, 0.3, deflection=x), f32([1e-5, -2e-5, 3e-5]), "deflection"
    ),
    "deflection.replan: axis": Case(
        lambda x: tp.replan(ON_MACHINE, 0.3, f32(ON_MACHINE.tip(0.3)[0]), axis=x), f32(ON_MACHINE.tip(0.3)[1]), "axis",
        optional=True,
    ),
}  # fmt: skip
CASES |= {
    f"ToolPath: {name}": Case(lambda x, name=name: line(**{name: x}), clean, name, name == "feed")
    for name, clean in LINE.items()
}
CASES |= {
    f"SetPoints: {name}": Case(
        lambda x, name=name, points=points: dataclasses.replace(points, **{name: x}),
        f32(getattr(points, name)), name, name != "block", name != "block",
    )
    for points, names in ((POINTS, ("t", "q", "qd", "qdd", "qddd", "block")), (ON_TOOL, ("tip", "axis")))
    for name in names
}  # fmt: skip
CASES["SetPoints: tool_length"] = Case(
    lambda x: dataclasses.replace(ON_TOOL, tool_length=x), np.full(len(ON_TOOL), 0.25), "tool_length", True, True
)

S = f32([0.0, 0.25, 0.5, 0.75])
AXIS_RUNS = [
    path.runs[0]
    for path in (
        WAYPOINTS, sine(), tp.AxisPath.from_waypoints(POSES[:2]), ON_MACHINE.axis_path,
        tp.replan(ON_MACHINE, 0.3, ON_MACHINE.tip(0.3)[0] + 1e-5).axis_path, tp.AxisPath.follow(EXACT, MACHINE),
    )
]  # fmt: skip
PATH_RUNS = [path.runs[0] for path in (EXACT, tp.Path.fit(DENSE), tp.Path.from_bspline(KNOTS, CONTROL, CONTROL + 0.1))]
LAWS = [
    *PLANNED.laws, *tp.plan(WAYPOINTS, LIMITS, planner="second-order").laws, *ON_MACHINE.laws,
    *tp.plan(WAYPOINTS, LIMITS, planner="genetic").laws,
]  # fmt: skip
for kind, objects, argument, methods in (
    ("AxisRun", AXIS_RUNS, "s", ("evaluate", "speed_cap", "with_cap", "block_at")),
    ("PathRun", PATH_RUNS, "s", ("evaluate", "tip_slope", "block_at", "block_index")),
    ("TimeLaw", LAWS, "t", ("at",)),
    ("TimeLaw", LAWS, "s", ("states_at", "times_at")),
):
    for method in methods:
        CASES[f"{kind}.{method}: {argument}"] = Case(
            lambda x, objects=objects, method=method: [getattr(each, method)(x) for each in objects], S, argument
        )
