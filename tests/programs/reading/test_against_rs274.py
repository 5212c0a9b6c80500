"""LinuxCNC's own interpreter (`rs274`) reads random programs as we do: places, order, feeds, dwells, refusals.

More by `python -m testbed.against_rs274 --programs N`.
"""

from __future__ import annotations

import numpy as np
import pytest

from testbed.against_rs274 import Job, difference, surprise
from testbed.linuxcnc.canon import read_calls
from testbed.linuxcnc.programs import random_job
from testbed.linuxcnc.rs274 import available, judged

linuxcnc = pytest.mark.linuxcnc
HEAD = "G21 G90 G94 G17 G91.1 F600\n"


@pytest.fixture(autouse=True)
def _installed(request):
    if request.node.get_closest_marker("linuxcnc") and available() is None:
        pytest.skip("rs274 is not installed (apt-get install --no-install-recommends linuxcnc-uspace)")


def different(seeds: range) -> list[str]:
    found = ((seed, surprise(random_job(seed))) for seed in seeds)
    return [f"seed {seed}: {what}" for seed, what in found if what]


@pytest.mark.sweep
@linuxcnc
def test_forty_random_programs():
    assert not different(range(40))


@linuxcnc
@pytest.mark.sweep
def test_a_hundred_and_sixty_random_programs():
    assert not different(range(40, 200))


@linuxcnc
@pytest.mark.thorough
def test_five_thousand_random_programs():
    assert not different(range(200, 5200))


@linuxcnc
@pytest.mark.parametrize("word", ["R3", "Q3", "G81 R3", "F50", "X3 R3", "G98"])
def test_words_of_a_cycle_in_a_block_of_their_own(word):
    """What drills again, what is kept for the next hole, and what both refuse."""
    assert not difference(Job(HEAD + f"G0 X0 Y0 Z10\nG99 G81 X1 Y0 Z-3 R2\n{word}\nX2\nG80\nM2\n"))


@linuxcnc
@pytest.mark.parametrize("offset", ["G54", "G55", "G59", "G59.1", "G59.3"])
@pytest.mark.parametrize("number", [0, 1, 2, 7, 9])
def test_g10_l20_in_and_out_of_the_offset_in_force(offset, number):
    last = "G54 G1 X1 Y1\nG55 X1 Y1\nG59.1 X1 Y1\nG59.3 X1 Y1\nM2\n"
    assert not difference(Job(HEAD + f"G0 X1 Y2 Z3\n{offset}\nG0 X2 Y2\nG10 L20 P{number} X7 Y8\nG1 X4 Y5\n" + last))


# --- the judge itself: what is told wrong, it tells -----------------------------------------------------------------

PROGRAM = HEAD + "G0 X1 Y2 Z3\nG1 X10 F500\nG2 X20 Y2 I5 J0\nG4 P1\nG1 A10 Z1\nM2\n"


@linuxcnc
def test_the_judge_agrees_on_a_plain_program():
    assert difference(Job(PROGRAM)) == ""


@linuxcnc
@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("X10 F500", "X10.001 F500", "off"), ("F500", "F501", "we take"), ("G2 X20", "G3 X20", "off"),
        ("G0 X1", "G1 X1", "rapid with one"), ("P1", "P1.5", "waited"), ("A10", "A10.01", "off"),
        ("G1 A10 Z1\n", "", "we go on"), ("G4 P1\n", "", "waited"), ("Z1\n", "Z1\nG1 X0\n", "ends before"),
        ("G4 P1", "G4", "refused by rs274 only"),
    ],
)  # fmt: skip
def test_the_judge_tells_two_programs_apart(monkeypatch, right, wrong, said):
    """Ours reads one, the interpreter another that differs in one word."""
    other = PROGRAM.replace(right, wrong)
    assert other != PROGRAM
    monkeypatch.setattr("testbed.against_rs274.judged", lambda text, *tables, **more: judged(other, *tables, **more))
    assert said in difference(Job(PROGRAM))


def test_calls_become_motions_of_the_machine():
    """Offsets are added in the order of LinuxCNC's canon: G92, rotation, work offset, tool."""
    calls = """
    1 N1     USE_LENGTH_UNITS(CANON_UNITS_MM)
    2 N1     SET_G5X_OFFSET(1, 100.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)
    3 N2     SET_XY_ROTATION(90.0000)
    4 N3     SET_G92_OFFSET(5.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)
    5 N4     USE_TOOL_LENGTH_OFFSET(0.0000 0.0000 7.0000, 0.0000 0.0000 0.0000, 0.0000 0.0000 0.0000)
    6 N5     STRAIGHT_TRAVERSE(1.0000, 2.0000, 3.0000, 4.0000, 0.0000, 0.0000)
    7 N6     SET_FEED_RATE(60.0000)
    8 N7     ARC_FEED(1.0000, 2.0000, 1.0000, 3.0000, -1, 3.0000, 4.0000, 0.0000, 0.0000)
    9 N8     DWELL(1.5000)
   10 N9     STRAIGHT_FEED(1.0000, 2.0000, 3.0000, 34.0000, 0.0000, 0.0000)
   11 N9     PROGRAM_END()
   12 N9     STRAIGHT_FEED(9.0000, 2.0000, 3.0000, 34.0000, 0.0000, 0.0000)
    """
    first, circle, turn = read_calls(calls).motions
    assert first.rapid and np.allclose(first.end, [98, 6, 10, 4, 0, 0])
    assert np.isclose(circle.sweep, -2 * np.pi) and np.allclose(circle.centre[:2], [97, 6])
    assert np.isclose(circle.seconds(), 2 * np.pi) and circle.line == 7
    assert np.isclose(turn.seconds(), 30.0) and turn.waited == 1.5 and turn.length() == 30.0
