"""Judging takes time in proportion to set-points, where much of the program lies within the tolerance of each too."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.growth import NEARLY_LINEAR, order_of_growth
from toolpace.judge.alignment import Lost, align
from toolpace.judge.alignment.sweep import NEVER, Line, Sweep


def turns(count, radius, *, parts=40, dwell=0, pitch=0.0):
    """A motion (n, 6) and a program (m, 6) that turn on a circle, radius and pitch in tolerances; it waits half way."""
    rows = []
    for step in (0.93, 1.0):
        angle = np.arange(0.0, 2.0 * np.pi * count, 2.0 * np.pi / parts * step)
        row = np.zeros((len(angle) + 1, 6))
        angle = np.append(angle, 2.0 * np.pi * count)
        row[:, 3], row[:, 4] = (radius + pitch * angle) * np.cos(angle), (radius + pitch * angle) * np.sin(angle)
        rows.append(row)
    motion, program = rows
    half = len(motion) // 2
    wait = np.repeat(motion[half : half + 1], dwell, axis=0)
    wait[:, 0] = 1e-3 * np.sin(np.arange(dwell))
    return np.concatenate((motion[:half], wait, motion[half:])), program


def judged(given):
    motion, program = given
    found = align(motion, program, 1.0, np.zeros(len(motion)))
    assert not isinstance(found, Lost) and not found.deviations
    return found


@pytest.mark.parametrize("radius, pitch", [(0.0, 0.0), (0.4, 0.0), (0.55, 0.0), (0.9, 0.0), (5.0, 0.0), (0.0, 0.05)])
def test_many_turns_of_a_rotary_joint(radius, pitch):
    few, many = turns(25, radius, pitch=pitch), turns(200, radius, pitch=pitch)
    assert order_of_growth(judged, few, many, 8.0) < NEARLY_LINEAR


@pytest.mark.parametrize("radius", [0.35, 0.45, 0.6, 0.8])
def test_turns_about_a_tip_beside_them_are_passed_at_once(radius):
    """A table turns 400 times under a tip that is near all of each turn, though not in its plane and near no ball about
    it: some cells for each pose, where way by way there are 28 800."""
    program, motion = (np.zeros((400 * parts + 1, 6)) for parts in (72, 40))
    for row, around in ((program, radius), (motion, 0.1)):
        angle = np.linspace(0.0, 800.0 * np.pi, len(row))
        row[:, 0], row[:, 1] = around * np.cos(angle), around * np.sin(angle)
    motion[:, 2] = 0.97 * np.sqrt(1.0 - (radius + 0.1) ** 2)
    line = Line(program, np.zeros(len(program)), np.zeros((len(program) - 1, 2)))
    sweep = Sweep(motion, np.zeros((len(motion) - 1, 2)), line, np.ones(len(motion)))
    assert sweep.run(-1, len(motion) - 1) == len(motion) - 1 and sweep.ends()
    assert NEVER - sweep.work < 150 * len(motion)


def test_long_dwells():
    few, many = turns(10, 0.4, dwell=2_000), turns(10, 0.4, dwell=16_000)
    assert order_of_growth(judged, few, many, 8.0) < NEARLY_LINEAR


def test_a_motion_of_another_program_ends():
    """Neither an answer for ever, nor a distance that is not there."""
    r = np.random.default_rng(1)
    for size in (1.0, 30.0, 1000.0):
        motion, program = (np.cumsum(r.normal(0.0, size, (800, 6)), axis=0) for _ in range(2))
        found = align(motion, program, 1.0, np.zeros(len(motion)))
        apart = max(np.linalg.norm((motion[-1] - program[-1])[half]) for half in (slice(0, 3), slice(3, 6)))
        if isinstance(found, Lost):
            assert found.distance > 1.0
        else:
            assert max(far for _, far in found.deviations) > 0.99 * apart
