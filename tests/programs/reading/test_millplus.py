"""MillPlus: words that posts write, and what is refused, with its cure."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.controllers import read_for, tips
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

START = "%PM1\nN10 G71 G90 G94 F600.\nN20 G0 X0. Y0. Z50. B0. C0.\nN30 G141 L2=0 F2=15000.\n"


@pytest.mark.parametrize("words", ["I1=0.6 J1=0. K1=0.8", "I1=0.1", "K1=1."])
def test_a_tools_direction_under_g141_is_refused(words):
    """Its rotary words turn X and Y with the table (one program of NX's post shows it); what its vectors are in is
    not known, so that both cannot be read together."""
    machine = Machine.load("xyzbc-trunnion")
    with pytest.raises(ProgramError, match=r"[IK]1= of G141.*write the positions of the rotary axes"):
        read_for("millplus", f"{START}N40 G1 X5. {words}\nN50 G40\nN60 M30\n", machine)
    path = read_for("millplus", f"{START}N40 G1 X5. B10. C30.\nN50 G40\nN60 M30\n", machine)
    assert len(path) > 1


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("G8 X1.", "G8"), ("G9 X1. Y1.", "G9"), ("G14 N1=10 N2=20", "G14"), ("G22 N=100", "G22"), ("G29 N=10", "G29"),
        ("G51", "G51"), ("G72", "G72"), ("G73 B4=30.", "G73"), ("G77 X0. Y0. R10.", "G77"), ("G87 X10. Y10.", "G87"),
        ("G192 X1.", "G192"), ("G999 X1.", "G999"), ("G41 D1", "G41"),
    ],
)  # fmt: skip
def test_words_that_may_move_something_are_refused(block, said):
    with pytest.raises(ProgramError, match=rf"\b{said}\b"):
        read_for("millplus", f"%PM1\nG71 G90 G94 F600.\nG0 X0. Y0. Z50.\n{block}\nG1 X5.\nM30\n")


HEAD = "%PM1\nG71 G90 G94 F600.\nG0 X0. Y0. Z50.\n"


@pytest.mark.parametrize("block", ["G99 X-10. Y-10. Z-30. I120. J120. K40.", "G98 X5. Y6. Z7.", "G195 X1. Y2. Z3. I4."])
def test_the_blocks_of_the_picture_move_nothing(block):
    """G98, G99, G195: window and blank of the graphics, which Autodesk's post writes at the beginning."""
    assert tips("millplus", f"{HEAD}{block}\nG1 X5.\nM30") == [[0, 0, 50], [5, 0, 50]]


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("G28 X10.", "G28 with axes"), ("G54 I3 X10.", "G54 with X, Y, Z"), ("T2 M67", "M67"),
        ("G1 X10.\nG3 I0. J0. B5=90.", "B5= of an arc"), ("G1 X10.\nG3 X5. I0. J0. B5=360.", "B5= of an arc"),
    ],
)  # fmt: skip
def test_words_that_moved_or_were_passed_over(block, said):
    with pytest.raises(ProgramError, match=said):
        read_for("millplus", f"{HEAD}{block}\nG1 X5.\nM30\n")


def test_how_ways_follow_each_other_moves_nothing():
    path = read_for("millplus", f"{HEAD}G28 I4=1 I5=1\nG1 X5.\nM30\n")
    assert path.tip[-1].tolist() == [0.005, 0.0, 0.05] and path.skipped == {"G28": 1}


def test_a_rapid_along_the_tool_and_aside_is_said():
    said = "G0 along the tool and aside in one block is taken to be straight"
    for block, there in (("G0 X5. Z10.", True), ("G0 X5. Y10.", False), ("G0 Z10.", False), ("G1 X5. Z10.", False)):
        path = read_for("millplus", f"{HEAD}{block}\nG1 X9.\nM30\n")
        assert any(said in each for each in path.assumed) == there


@pytest.mark.parametrize("word", ["M6", "M46", "M66"])
def test_a_tool_that_is_changed_by_hand_counts_with_its_own_length(word):
    """M66 is the change by hand (Autodesk's post); it was taken for a function at rest, with the tool before."""
    sheet = SetUp(tools={"1": Tool(0.1, 0.005), "2": Tool(0.15, 0.005)}, offsets={"G54": {}})
    text = f"%PM1\nG71 G90 G94 F600.\nG54\nT1 M6\nG0 X0. Y0. Z50.\nT2 {word}\nG1 X5. Z50.\nM30\n"
    path = read_for("millplus", text, Machine.load("xyzbc-trunnion"), setup=sheet)
    assert path.tool_length[[0, -1]].tolist() == [0.1, 0.15]


@pytest.mark.parametrize(("first", "centre"), [("I0. J0.", (5, 10)), ("I-10. J0.", (15, 10)), ("I10. J0.", (5, 10))])
def test_centres_that_fit_both_ways_are_read_as_the_arcs_before(first, centre):
    """From X10 Y0 to X10 Y20 a position I5 J10 is as far from both ends as a distance; a quarter from X10 Y0 to X0 Y10
    about the origin tells by its words which is meant: a position, or a distance, counted in either sense."""
    second = {"I0. J0.": "I5. J10.", "I-10. J0.": "I5. J10.", "I10. J0.": "I5. J-10."}[first]
    text = f"{HEAD}G1 X10.\nG3 X0. Y10. {first}\nG1 X10. Y0.\nG3 X10. Y20. {second}\nM30\n"
    path = read_for("millplus", text)
    arc = path.tip[path.block == 7] * 1e3
    assert np.hypot(arc[:, 0] - centre[0], arc[:, 1] - centre[1]) == pytest.approx(math.hypot(5, 10))
    with pytest.raises(ProgramError, match="fit as a position and as a distance"):
        read_for("millplus", f"{HEAD}G1 X10.\nG3 X10. Y20. I5. J10.\nM30\n")


@pytest.mark.parametrize("turn", ["B5=360", "X10. Y0."])
def test_a_full_circle(turn):
    """Autodesk's post writes the centre as a position, and B5=360."""
    path = read_for("millplus", f"{HEAD}G1 X10.\nG3 I4. J0. {turn}\nM30\n")
    arc = path.tip[path.block == 5] * 1e3
    assert np.hypot(arc[:, 0] - 4.0, arc[:, 1]) == pytest.approx(6.0)
    assert arc[:, 1].max() > 5.9 and arc[:, 1].min() < -5.9


@pytest.mark.parametrize(
    ("cycle", "into", "out"),
    [("G84 Z-20. Y2. J1.5 I1=1 S500", 750, 750), ("G85 Z-20. Y2. F100. F2=500.", 100, 500), ("G85 Z-9. Y2.", 600, 600)],
)
def test_feeds_of_cycles(cycle, into, out):
    """The pitch by the turns of the spindle, and F2= on the way out: both went at the feed in force."""
    path = read_for("millplus", f"{HEAD}{cycle}\nG79 X10. Y10. Z0.\nM30\n")
    below = int(path.tip[:, 2].argmin())
    assert path.feed[[below, below + 1]] * 6e4 == pytest.approx([into, out])
