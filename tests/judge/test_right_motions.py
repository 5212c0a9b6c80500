"""Programs whose plans keep every limit and are found right: waits shorter than a step, blocks shorter than one, blocks
by inverse time that are slow for an instant, and feeds that are reached within a step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support import motions
from toolpace.judge import verify
from toolpace.judge.figures import Figures
from toolpace.machine.machine import Machine
from toolpace.path.path import Path
from toolpace.planning.limit_tolerances import PROMISED
from toolpace.planning.planner import plan
from toolpace.planning.program_plan import plan_program
from toolpace.programs.reading import read_text

HEAD = "G21 G90 G94\nG0 X0 Y0 Z5 {0}0 {1}0\n"


def planned(machine, body):
    """The plan of a program and the program."""
    text = HEAD.format(*(machine.joints[joint] for joint in machine.rotary)) + body + "M30\n"
    toolpath = read_text(text, machine, "gcode")
    return plan(Path.fit(toolpath, 10e-6, 1e-3, machine), machine, bound=False), toolpath


@pytest.mark.parametrize("dt", [2.5e-4, 1e-3, 4e-3])
@pytest.mark.parametrize("wait", [1e-4, 5e-4, 1e-3, 1.7e-3, 2e-3, 3e-3, 8e-3])
def test_a_wait_of_any_length_is_seen(wait, dt):
    """What is shorter than two steps may lie across a set-point, and leave no step without motion."""
    machine = Machine.load("xyzac-trunnion")
    ways = "".join(f"X{way}\nG4 P{wait}\n" for way in (-2.681, 1.3, 1.35, 0.2, 0.1))
    trajectory, toolpath = planned(machine, f"G1 X1 F1000\nG4 P{wait}\n{ways}X3\n")
    assert verify(trajectory, machine, toolpath, 10e-6, 1e-3, dt).ok
    missed = toolpath.dwell.copy()
    missed[np.flatnonzero(missed)[2]] += 2.0 * dt + 1e-4
    found = verify(trajectory, machine, replace(toolpath, dwell=missed), 10e-6, 1e-3, dt)
    assert not found.ok


@pytest.mark.parametrize("feeds", [(18, 3, 12, 8, 13, 158, 58, 4), (40, 300, 4, 90, 9, 200, 3, 30)])
@pytest.mark.parametrize("name", ["paper-ab", "xyzac-trunnion"])
def test_blocks_by_inverse_time_keep_their_feed_at_any_time(name, feeds):
    """The cap jumps fifty-fold from block to block: speeds turn within one cell, between two places looked at."""
    machine = Machine.load(name)
    places = ((-2.243, 2.264), (-1.896, 0.061), (-0.103, 7.546), (3.971, -0.915))
    places += ((6.48, -7.731), (7.984, -3.806), (1.691, 4.897), (-2.197, 4.173))
    blocks = "".join(f"G1 X{x} Y{y} F{feed}\n" for (x, y), feed in zip(places, feeds))
    trajectory, toolpath = planned(machine, f"G93\n{blocks}G94 F500\nG1 X0 Y0\n")
    assert trajectory.usage().worst <= PROMISED
    assert verify(trajectory, machine, toolpath, 10e-6, 1e-3).ok


def test_an_open_place_may_lie_in_a_block_between_two_set_points():
    """Of blocks that take less than a step some have no set-point."""
    points, program = motions.set_points(), motions.program()
    points = replace(points, block=points.block - points.block % 3)
    k = int(np.flatnonzero(np.diff(points.block))[40])
    said = {"duration_s": float(points.t[-1]), "open_places": []}

    def found(block):
        place = {"from_s": float(points.t[k]), "to_s": float(points.t[k]), "gain_s": 1e-3, "block": block}
        figures = Figures({**said, "open_places": [place]}, points, motions.machine(), program, None, None)
        return figures.of_places()[0].ok

    assert found(int(points.block[k])) and found(int(points.block[k]) + 1)
    assert not found(int(points.block[0])) and not found(int(points.block[-1]))
    assert not Figures(
        {**said, "open_places": [{"from_s": 0.1, "to_s": 0.1, "gain_s": 0.0, "block": 12}]},
        points, motions.machine(), replace(program, block=3 * program.block), None, None,
    ).of_places()[0].ok  # fmt: skip


@pytest.mark.parametrize("effort", ["low", "high"])
def test_a_feed_that_is_reached_within_a_step_is_no_false_column(effort):
    """However slow the feed, or long the step: moves of 10 micrometres at 0.1 mm/min and more."""
    machine = Machine.load("xyzac-trunnion")
    for feed in (0.1, 1.0, 10.0):
        text = HEAD.format("A", "C") + f"G1 F{feed} X0.01\nX0.02 Y0.01\nX0.03\nM30\n"
        toolpath = read_text(text, machine, "gcode")
        trajectory = plan_program(toolpath, machine, 10e-6, 1e-3, effort=effort).trajectory
        for dt in (1e-3, 2e-3, 1e-2, 2e-2, 5e-2):
            found = verify(trajectory, machine, toolpath, 10e-6, 1e-3, dt)
            assert not found.findings, (feed, dt)
