"""Wrong uses of public functions: each row of docs/design/wrong_use.md has a case here, and says what happens."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import ToolpaceError

PAGE = Path(__file__).parent.parent / "docs" / "design" / "wrong_use.md"
MACHINE = tp.Machine.load("xyzac-trunnion")
PROGRAM = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 X20 F3000\nX40 A10\nY20\nM2\n"


@cache
def program() -> tp.ToolPath:
    return tp.read_text(PROGRAM, MACHINE)


@cache
def path() -> tp.Path:
    return tp.Path.fit(program(), machine=MACHINE)


@cache
def planned() -> tp.Trajectory:
    return tp.plan(path(), MACHINE, bound=False)


@cache
def follower() -> tp.Follower:
    return tp.Follower(planned(), MACHINE)


def tool_path(**other: Any) -> tp.ToolPath:
    n = 2
    plain: dict[str, Any] = {
        "tip": np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]), "axis": np.array([[0.0, 0.0, 1.0]] * n),
        "feed": np.array([np.inf, 0.05]), "least_time": np.zeros(n), "block": np.array([1, 2]),
        "stop": np.array([True, True]), "dwell": np.zeros(n),
    }  # fmt: skip
    return tp.ToolPath(**{**plain, **other})


def cut(**other: Any) -> tp.Cut:
    plain: dict[str, Any] = {
        "cutter": tp.Cutter(0.004, 2), "coefficients": tp.Coefficients(8e8, 3e8),
        "engagement": tp.Engagement("down", 0.008, 0.00015), "spindle_speed": 300.0,
    }  # fmt: skip
    return tp.Cut(**{**plain, **other})


def shown(measurement: tp.Measurement) -> str:
    """What a follower says of a measurement, in one step from its start."""
    live = follower()
    live.reset()
    return repr(live.step(measurement).status)


def knots() -> np.ndarray:
    return np.r_[np.zeros(4), np.ones(4)]


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "read: the text of a program": (lambda: tp.read(PROGRAM, MACHINE), "tp.read_text"),
    "read: the name of a machine": (lambda: tp.read_text(PROGRAM, "xyzac-trunnion"), "give a Machine"),  # type: ignore[arg-type]
    "read: limits for the machine": (lambda: tp.read_text(PROGRAM, MACHINE.limits), "Limits; give a Machine"),  # type: ignore[arg-type]
    "read: a feed without unit": (lambda: tp.read_text(PROGRAM, MACHINE, feed=3000), "with its unit"),  # type: ignore[arg-type]
    "read: a word for a switch": (lambda: tp.read_text(PROGRAM, MACHINE, lenient="no"), "give True or False"),  # type: ignore[arg-type]
    "read: a mapping for the sheet": (lambda: tp.read_text(PROGRAM, MACHINE, setup={}), "in place of a set-up sheet"),  # type: ignore[arg-type]
    "read_text: the path of a file": (lambda: tp.read_text(__file__, MACHINE), "is the name of a file"),
    "read_text: bytes": (lambda: tp.read_text(b"G0", MACHINE), "bytes in place of the text"),  # type: ignore[arg-type]
    "program_time: machine and program changed over": (
        lambda: tp.program_time(MACHINE, __file__), "Machine in place of the path|machine is"  # type: ignore[arg-type]
    ),
    "apply_feed: a factor": (lambda: tp.apply_feed(program(), 1.2), "with its unit"),  # type: ignore[arg-type]
    "ToolPath: axes not of length 1": (lambda: tool_path(axis=np.array([[0.0, 0.0, 90.0]] * 2)), "divide it by"),
    "ToolPath.with_tool: a length in mm": (lambda: program().with_tool(120), "120 mm is 0.12"),
    "Tool: a length in mm": (lambda: tp.Tool(120.0), "120 mm is 0.12"),
    "Tool: a radius in mm": (lambda: tp.Tool(0.12, 5.0), "tool: radius is 5"),
    "SetUp: an offset in mm": (lambda: tp.SetUp(offsets={"G54": {"X": -120.0}}), "X of G54 is -120"),
    "Path.fit: a program for its tool path": (lambda: tp.Path.fit(PROGRAM), "str in place of a tool path"),  # type: ignore[arg-type]
    "Path.fit: a machine for the tolerance": (lambda: tp.Path.fit(program(), MACHINE), "tip_tolerance is"),  # type: ignore[arg-type]
    "Path.fit: limits for the machine": (
        lambda: tp.Path.fit(program(), machine=MACHINE.limits), "Limits in place of a machine"  # type: ignore[arg-type]
    ),
    "Path.arc: a feed in mm/min": (
        lambda: tp.Path.arc([0, 0, 0], [0.1, 0, 0], [0, 0, 1], 1.5, feed=3000.0), "3000 mm/min is 0.05"  # type: ignore[arg-type]
    ),
    "plan: a tool path": (lambda: tp.plan(program(), MACHINE), "make it smooth first"),  # type: ignore[arg-type]
    "plan: path and machine changed over": (lambda: tp.plan(MACHINE, path()), "in place of a machine"),  # type: ignore[arg-type]
    "plan: limits for the machine": (lambda: tp.plan(path(), MACHINE.limits), "needs a machine"),
    "plan: a number for the start": (lambda: tp.plan(path(), MACHINE, start=0.1), "give an EndState"),  # type: ignore[arg-type]
    "plan_program: a program for its tool path": (
        lambda: tp.plan_program(PROGRAM, MACHINE), "str in place of a tool path"  # type: ignore[arg-type]
    ),
    "prove: a gap in percent": (lambda: tp.prove(planned(), gap=1.0), "0.01 percent is 1e-4"),
    "prove: a time below zero": (lambda: tp.prove(planned(), within=-1.0), "within is -1"),
    "verify: a program for its tool path": (
        lambda: tp.verify(planned(), MACHINE, PROGRAM), "str in place of a tool path"  # type: ignore[arg-type]
    ),
    "verify: limits for the machine": (
        lambda: tp.verify(planned(), MACHINE.limits, program()), "judged on a Machine"
    ),
    "verify: tool path and machine changed over": (
        lambda: tp.verify(planned(), program(), MACHINE), "in place of a"  # type: ignore[arg-type]
    ),
    "verify: the path of the sheet": (
        lambda: tp.verify(planned(), MACHINE, program(), sheet="/a/sheet.toml"), "not the text of a set-up sheet"
    ),
    "report: path and trajectory changed over": (lambda: tp.report("a.html", planned()), "in place of a trajectory"),  # type: ignore[arg-type]
    "report: a verification for the tool path": (
        lambda: tp.report(planned(), "a.html", tp.verify(planned(), MACHINE)), "in place of a tool path"  # type: ignore[arg-type]
    ),
    "export: target and folder changed over": (
        lambda: tp.export(planned(), Path("out"), "table"), "there is no such target"  # type: ignore[arg-type]
    ),
    "export: a period in ms": (lambda: tp.export(planned(), "table", "out", period=4), "--period 4.00 s"),
    "replan: a vector for the position": (lambda: tp.replan(planned(), 0.1, [6e-6, 0, 0]), "that is a vector"),
    "replan: a position in mm": (lambda: tp.replan(planned(), 0.1, 1e3 * planned().tip(0.1)[0]), "is in mm"),
    "replan: a time in ms": (lambda: tp.replan(planned(), 100, deflection=[0, 0, 0]), "is not within"),
    "replan: another machine": (
        lambda: tp.replan(planned(), 0.1, planned().tip(0.1)[0], tp.Machine.load("paper-ab")), "more than the 5 mm"
    ),
    "replan: a change of the axis": (
        lambda: tp.replan(planned(), 0.1, deflection=[0, 0, 0], axis=[0.0, 1e-3, 0.0]), "give the unit vector"
    ),
    "replan: axis_tolerance in degrees": (
        lambda: tp.replan(planned(), 0.1, deflection=[0, 0, 0], axis=[0.0, 0.0, 1.0], axis_tolerance=0.5),
        "give radians",
    ),
    "Follower: trajectory and machine changed over": (lambda: tp.Follower(MACHINE, planned()), "what plan returns"),  # type: ignore[arg-type]
    "Follower: a period in ms": (lambda: tp.Follower(planned(), MACHINE, period=1), "a time from 1e-05 to 0.1 s"),
    "Follower: max_correction in mm": (lambda: tp.Follower(planned(), MACHINE, max_correction=0.3), "0.3 mm is 0.3e-3"),
    "Follower: deadband in mm": (lambda: tp.Follower(planned(), MACHINE, deadband=0.001), "2 um is 2e-6"),
    "Follower: believable in mm": (lambda: tp.Follower(planned(), MACHINE, believable=3.0), "0.3 mm is 0.3e-3"),
    "Follower: wait in mm": (lambda: tp.Follower(planned(), MACHINE, wait=0.05), "0.3 mm is 0.3e-3"),
    "Follower: filter in ms": (lambda: tp.Follower(planned(), MACHINE, filter=5.0), "a time from 0 to 2 s"),
    "Follower: axis_tolerance in degrees": (
        lambda: tp.Follower(planned(), MACHINE, axis_tolerance=0.05), "0.05 deg is 0.9e-3"
    ),
    "Follower: compliance in um/N": (lambda: tp.Follower(planned(), MACHINE, compliance=0.08 * np.eye(3)), "give m/N"),
    "Machine.load: the text of a file": (lambda: tp.Machine.load(MACHINE.to_toml()), "unknown machine"),
    "Machine.from_toml: a name": (lambda: tp.Machine.from_toml("xyzac-trunnion"), "not a TOML file"),
    "Machine.with_tool: a length in mm": (lambda: MACHINE.with_tool(120), "120 mm is 0.12"),
    "Machine.mounted: an origin in mm": (lambda: MACHINE.mounted([0.0, 0.0, 60.0]), "origin is 60"),
    "Machine.reserved: percents": (lambda: MACHINE.reserved(10), "a share from 0"),
    "Machine.with_limits: a machine": (lambda: MACHINE.with_limits(MACHINE), "in place of limits"),  # type: ignore[arg-type]
    "Machine.rotary_solutions: angles for axes": (
        lambda: MACHINE.rotary_solutions([[45.0, 90.0, 0.0]]), "the unit vector from the tip"  # type: ignore[arg-type]
    ),
    "Machine.check_travel: positions in mm": (
        lambda: MACHINE.check_travel([[100.0, 0, 0, 0, 0]], [1]), "above its limit"
    ),
    "Limits: arrays of another shape": (lambda: tp.Limits(np.ones((2, 2)), 1.0, 1.0), "give real numbers"),
    "Bending.cantilever: lengths in mm": (lambda: tp.Bending.cantilever(4, 40, 580e9), "diameter is 4"),
    "Bending.cantilever: a modulus in GPa": (lambda: tp.Bending.cantilever(0.004, 0.04, 580), "580 GPa is 580e9"),
    "Bending.of_stiffness: N/um": (lambda: tp.Bending.of_stiffness(12, 12, 100), "check its unit"),
    "Cut: a diameter in mm": (lambda: cut(cutter=tp.Cutter(4, 2)), "diameter is 4"),
    "Cut: a helix in degrees": (lambda: cut(cutter=tp.Cutter(0.004, 2, 30.0)), "give at most 80 deg"),
    "Cut: a run-out in mm": (lambda: cut(cutter=tp.Cutter(0.004, 2, 0.0, 0.005)), "a tenth of the diameter"),
    "Cut: depths in mm": (lambda: cut(engagement=tp.Engagement("down", 8, 0.15)), "axial_depth is 8"),
    "Cut: coefficients in MPa": (lambda: cut(coefficients=tp.Coefficients(800, 300)), "800 MPa is 8e8"),
    "Cut: edge forces in N/mm": (
        lambda: cut(coefficients=tp.Coefficients(8e8, 3e8, tangential_edge=25.0)), "25 N/mm is 25e3"
    ),
    "Cut: turns per minute": (lambda: cut(spindle_speed=18000.0), "18000 rpm is 300"),
    "CuttingForces.feed_per_tooth: mm/min": (
        lambda: tp.CuttingForces(cut()).feed_per_tooth(3000.0), "3000 mm/min is 0.05"
    ),
    "Clamping: angles in degrees": (lambda: tp.Clamping(turn=90.0), "90 deg is 1.571"),
    "Clamping: a shift in mm": (lambda: tp.Clamping(shift=(100.0, 0.0, 0.0)), "shift is 100"),
    "Choice.between: the higher first": (lambda: tp.Choice.between(1.0, 0.0), "the lower one first"),
    "Choices: angles in degrees": (lambda: tp.Choices(turn=tp.Choice.between(-180, 180)), "90 deg is 1.571"),
    "Choices: places in mm": (lambda: tp.Choices(x=tp.Choice.between(-100, 100)), "120 mm is 0.12"),
    "Zone: bounds in mm": (lambda: tp.Zone("fixture", {"X": (100.0, 200.0)}), "120 mm is 0.12"),
    "Zone: the higher bound first": (lambda: tp.Zone("fixture", {"X": (0.2, 0.1)}), "the lower one first"),
    "compensate_bending: the path of a tool file": (
        lambda: tp.compensate_bending(program(), MACHINE, "tool.toml"),  # type: ignore[arg-type]
        "load_tool",
    ),
    "write_set_up: nothing found": (lambda: tp.write_set_up("out", None, "part"), "search_setup returns"),  # type: ignore[arg-type]
    "batch: a path for the jobs": (lambda: tp.batch("part.ngc", client=0), "give a list of BatchJob"),  # type: ignore[arg-type]
    "BatchJob: a tool length in mm": (
        lambda: tp.BatchJob(program="a", machine="xyzac-trunnion", tool_length=120.0), "120 mm is 0.12"
    ),
    "load_tool: the text of a file": (lambda: tp.load_tool("[tool]\n"), "cannot be read"),
    "Trajectory.load: a program": (lambda: tp.Trajectory.load(__file__), "no such folder"),
    "SetPoints.load: a folder": (lambda: tp.SetPoints.load("."), "is a directory"),
}  # fmt: skip
ASKED: dict[str, tuple[Callable[[], Any], str]] = {
    "Path.fit: a tolerance in mm": (lambda: tp.Path.fit(program(), 0.01, machine=MACHINE), "tip_tolerance is 0.01"),
    "Path.fit: a tolerance in degrees": (lambda: tp.Path.fit(program(), 1e-5, 0.05, machine=MACHINE), "axis_tolerance"),
    "verify: a tolerance in mm": (lambda: tp.verify(planned(), MACHINE, program(), 0.01), "tip_tolerance is 0.01"),
    "verify: Tolerances in mm": (
        lambda: tp.verify(planned(), MACHINE, program(), tp.Tolerances(0.01)), "tip_tolerance is 0.01"
    ),
    "Trajectory.sample: a step in ms": (lambda: planned().sample(1), "time step dt is 1, .* 1 ms is 1e-3"),
    "Path.arc: an angle in degrees": (
        lambda: tp.Path.arc([0, 0, 0], [0.1, 0, 0], [0, 0, 1], 90.0), "90 deg is 1.571"  # type: ignore[arg-type]
    ),
    "ToolPath: points in mm": (lambda: tool_path(tip=np.array([[0.0, 0, 0], [100.0, 0, 0]])), "120 mm is 0.12"),
    "ToolPath: feeds in mm/min": (lambda: tool_path(feed=np.array([np.inf, 3000.0])), "3000 mm/min is 0.05"),
    "Limits.scaled: percents": (lambda: MACHINE.limits.scaled(120), "120 percent is 1.2"),
    "AxisPath.from_waypoints: degrees": (
        lambda: tp.AxisPath.from_waypoints([[0.0, 0.0], [90.0, 45.0], [180.0, 90.0]]), "are these mm or degrees"
    ),
}  # fmt: skip
SAID: dict[str, tuple[Callable[[], Any], Callable[[Any], bool]]] = {
    "Follower.step: a vector for the tip": (
        lambda: shown(tp.Measurement(0.0, tip=[6e-6, 0, 0])), lambda s: "ABSURD" in s
    ),
    "Follower.step: a position for the deflection": (
        lambda: shown(tp.Measurement(0.0, deflection=planned().tip(0.0)[0])), lambda s: "ABSURD" in s
    ),
    "Follower.step: a measurement of a time in ms": (
        lambda: shown(tp.Measurement(40.0, deflection=[1e-6, 0, 0])), lambda s: "LATE" in s
    ),
    "Follower.step: percents of feed": (lambda: repr(follower().step(feed=80).status), lambda s: "OVERRIDE_CUT" in s),
    "deflection.project: a point in mm": (
        lambda: tp.deflection.project(path(), [20.0, 0.0, 50.0]).distance, lambda far: far > 50.0
    ),
}  # fmt: skip
UNSEEN: dict[str, tuple[Callable[[], Any], Callable[[Any], bool]]] = {
    "Trajectory.at: times in ms": (lambda: planned().at(500.0).qd, lambda v: not v.any()),
    "Machine.forward: degrees": (
        lambda: MACHINE.forward([0, 0, 0, 45.0, 90.0])[0], lambda p: bool(np.isfinite(p).all())
    ),
    "Machine.joints_at: tips in mm": (lambda: MACHINE.joints_at([100.0, 0, 0], [0.0, 0.0]), lambda q: q[0] == 100.0),
    "ToolPath: rotary joints in degrees": (
        lambda: tool_path(rotary=np.array([[0.0, 0.0], [45.0, 90.0]]), rotary_joints=("A", "C")), lambda t: len(t) == 2
    ),
    "Path.from_bspline: the tool axis for a point on it": (
        lambda: tp.Path.from_bspline(
            knots(), np.linspace([0.5, 0, 0], [0.6, 0, 0], 4), np.array([[0, 0, 1.0]] * 4)
        ),
        lambda p: len(p.runs) == 1,
    ),
    "replan: micrometres in mm": (
        lambda: tp.replan(planned(), 0.1, deflection=[0.0, 0.003, 0.0]).skipped, lambda told: told[0].off > 2.9e-3
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_use_is_refused_in_one_line_that_says_what_is_wanted(name: str) -> None:
    call, words = REFUSED[name]
    with pytest.raises(ToolpaceError, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ASKED)
def test_what_can_hardly_be_meant_is_asked_about(name: str) -> None:
    call, words = ASKED[name]
    with pytest.warns(tp.UnitWarning, match=words):
        call()


@pytest.mark.parametrize("name", [*SAID, *UNSEEN])
def test_what_is_taken_does_what_the_page_says(name: str) -> None:
    call, holds = {**SAID, **UNSEEN}[name]
    assert holds(call())


def test_the_page_lists_these_and_no_others() -> None:
    rows = re.findall(r"^\| `([^`]+)` \| ([^|]+?) \| (\w+)", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    told = {f"{function}: {use}": outcome for function, use, outcome in rows}
    wanted = {
        name: outcome
        for outcome, cases in (("refused", REFUSED), ("asked", ASKED), ("said", SAID), ("unseen", UNSEEN))
        for name in cases
    }
    assert told == wanted
