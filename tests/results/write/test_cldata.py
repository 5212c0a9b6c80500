"""A tool path written as cutter-location data is read again as the same."""

from __future__ import annotations

import numpy as np
import pytest

import toolpace as tp
from toolpace.cli.demo_programs import impeller_program
from toolpace.results.write.set_up_folder import cldata_text

INVERSE = """G21 G90 G43.4 H1
G0 X0 Y0 Z20 A0 C0
G93
G1 X10 A-20 C30 F40
G1 A-30 F55.5
G94
G1 X20 F1000
G4 P1.5
G1 Y5
G0 Z50
T2 M6
G1 X1 F500
M30
"""


def same(text: str) -> None:
    machine = tp.Machine.load("xyzac-trunnion")
    given = tp.read_text(text, machine)
    again = tp.read_text(cldata_text(given, "a note $ of two\nlines"), dialect="apt")
    np.testing.assert_allclose(again.tip, given.tip, atol=1e-12)
    np.testing.assert_allclose(again.axis, given.axis, atol=1e-11)
    np.testing.assert_allclose(again.feed[1:], given.feed[1:], rtol=1e-9)
    np.testing.assert_allclose(again.least_time, given.least_time, rtol=1e-7)
    for name in ("stop", "rapid", "dwell"):
        np.testing.assert_array_equal(getattr(again, name), getattr(given, name), err_msg=name)
    assert again.rotary is None


def test_a_program_in_joint_words_is_the_same_in_tips_and_axes():
    same(impeller_program(blocks_per_blade=12))


def test_inverse_times_stops_and_dwells_are_kept():
    same(INVERSE)


def test_operations_are_kept():
    text = "TOOL PATH/ROUGH,TOOL,T5\nGOTO/0,0,0\nFEDRAT/100,MMPM\nGOTO/1,0,0\nTOOL PATH/FINISH,TOOL,T5\nGOTO/1,2,0\n"
    given = tp.read_text(text, dialect="apt")
    again = tp.read_text(cldata_text(given), dialect="apt")
    assert again.operations == given.operations and len(given.operations) == 2
    np.testing.assert_array_equal(again.operation, given.operation)


@pytest.mark.parametrize("seed", range(5))
def test_random_points_are_kept(seed):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(30, 3))
    stop = rng.random(30) < 0.2
    stop[[0, -1]] = True
    rapid = rng.random(30) < 0.3
    feed = np.where(rapid, np.inf, rng.uniform(1e-4, 1.0, 30))
    given = tp.ToolPath(
        rng.normal(size=(30, 3)), axis / np.linalg.norm(axis, axis=1)[:, None], feed, np.zeros(30),
        np.arange(1, 31), stop, np.where(stop, rng.random(30), 0.0) * (np.arange(30) % 29 > 0),
    )  # fmt: skip
    again = tp.read_text(cldata_text(given), dialect="apt")
    np.testing.assert_allclose(again.tip, given.tip, atol=1e-12)
    np.testing.assert_allclose(again.axis, given.axis, atol=1e-11)
    np.testing.assert_array_equal(again.stop, given.stop)
    np.testing.assert_allclose(again.dwell, given.dwell, atol=1e-9)
    np.testing.assert_allclose(again.feed[1:], given.feed[1:], rtol=1e-6)
