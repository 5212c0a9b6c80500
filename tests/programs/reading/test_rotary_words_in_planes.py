"""Rotary words in a tilted plane turn their axes, and nothing follows them: the linear joints stand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import read_for
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import SetUp, Tool

TRUNNION = Machine.load("xyzac-trunnion")
HEAD = "G90 G21 G94 G17 F600\nT1 M6\nG54\nG0 A0. C0.\nG43 H1 X0 Y0 Z50.\n"
PLANES = {
    "fanuc": "G68.2 X10. Y5. Z0. I0 J25. K0",
    "haas": "G268 X10. Y5. Z0. I25.",
    "millplus": "G93 X10. Y5. Z0.\nG7 A5=25. A7=254 C7=255",
}


def joints(controller, body):
    """(n, 3 + 2) X, Y, Z [mm], A, C [deg] at the ends of blocks."""
    head = HEAD.replace("G21", "G71").replace("G43 H1 ", "") if controller == "millplus" else HEAD
    path = read_for(controller, head + body + "\nM30", TRUNNION, setup=SetUp(tools={"1": Tool(0.12)}))
    rows = np.flatnonzero(np.diff(path.block, append=-1))
    found = TRUNNION.joints_at(path.tip, path.rotary, path.tool_length)[rows]
    linear = found[:, [TRUNNION.joints.index(letter) for letter in "XYZ"]] * 1e3
    rotary = np.degrees(path.rotary[rows][:, [path.rotary_joints.index(letter) for letter in "AC"]])
    return np.hstack([linear, rotary])


@pytest.mark.parametrize("controller", PLANES)
def test_linear_joints_stand_while_a_program_turns_the_tool_to_a_plane(controller):
    """X, Y and Z of the machine are those of before, and behind the turn the plane's words count."""
    turn = "G0 A=E254 C=E255" if controller == "millplus" else "G0 A25. C0."
    found = joints(controller, f"{PLANES[controller]}\n{turn}\nX0 Y0 Z20.\nX7.")
    before, turned, first, second = found[-4:]
    assert turned[:3] == pytest.approx(before[:3], abs=1e-9) and abs(abs(turned[3]) - 25.0) < 1e-9
    assert second[:3] - first[:3] == pytest.approx([7.0, 0.0, 0.0], abs=1e-9)


def test_g53_1_and_the_same_rotary_words_are_one():
    by_word = joints("fanuc", f"{PLANES['fanuc']}\nG0 A25. C0.\nX1. Y2. Z20.")
    by_turn = joints("fanuc", f"{PLANES['fanuc']}\nG53.1\nG0 X1. Y2. Z20.")
    assert by_word[-1] == pytest.approx(by_turn[-1], abs=1e-6)


def test_positions_that_a_post_repeats_are_no_turn():
    """G53.1 turns to A25.1234567..., and the post writes A25.123 beside X and Y."""
    plane = "G68.2 X10. Y5. Z0. I0 J25.12345 K0\nG53.1\n"
    repeated = joints("fanuc", f"{plane}G0 X1. Y2. A25.123 C0.\nZ20.")
    assert repeated[-1] == pytest.approx(joints("fanuc", f"{plane}G0 X1. Y2.\nZ20.")[-1], abs=1e-9)


@pytest.mark.parametrize(
    ("controller", "body", "said"),
    [
        ("fanuc", f"{PLANES['fanuc']}\nG53.1\nG0 A0\nX0 Y0 Z20.", "in a tilted plane that the tool was turned off"),
        ("fanuc", f"{PLANES['fanuc']}\nG53.1\nG53 A0\nX0 Y0 Z20.", "in a tilted plane that the tool was turned off"),
        ("fanuc", f"{PLANES['fanuc']}\nG53.1\nG91 G28 A0\nG90 X1.", "in a tilted plane that the tool was turned off"),
        ("fanuc", f"{PLANES['fanuc']}\nG53.1\nG1 X5. A10.", "rotary words beside a motion in a tilted plane"),
        ("fanuc", f"{PLANES['fanuc']}\nG53.1\nG2 I5. A10.", "rotary words beside a motion in a tilted plane"),
        ("fanuc", f"{PLANES['fanuc']}\nG53.1\nG81 X5. C10. Z-5. R2.", "rotary words beside a motion in a tilted plane"),
        ("haas", "G0 A30. C10.\nG254\nG234 H1 G0 X0 Y0 Z50.", "G234 in a tilted plane is not read"),
        ("haas", "G254\nG0 A30. C10.\nX0 Y0 Z50.", "in a tilted plane that the tool was turned off"),
    ],
)
def test_what_would_move_the_plane_is_refused(controller, body, said):
    """Haas UMC operator's manual, G254: rotary motion is complete before it, and it ends before any other, and before
    axes move at once."""
    with pytest.raises(ProgramError, match=said):
        joints(controller, body)


def test_axes_may_turn_back_before_the_plane_ends():
    """Posts retract, turn home and write G69 last."""
    for turn in ("G0 A0 C0", "G28 A0 C0", "G91 G28 A0 C0", "G53 A0 C0"):
        home = f"G53 Z0\n{turn}\nG91 G28 X0 Y0\nG90 G69\nG0 X0 Y0"
        found = joints("fanuc", f"{PLANES['fanuc']}\nG53.1\nG0 X0 Y0 Z20.\n{home}")
        assert found[-1][3:] == pytest.approx([0.0, 0.0]) and found[-1][:2] == pytest.approx(found[0][:2], abs=1e-9)


def test_in_tip_mode_the_tip_stands_as_before():
    """G43.4 in a plane: rotary words turn about the tip."""
    body = f"{PLANES['fanuc']}\nG53.1\nG43.4 H1\nG0 X0 Y0 Z20.\nG1 A10."
    path = read_for("fanuc", HEAD + body + "\nM30", TRUNNION, setup=SetUp(tools={"1": Tool(0.12)}))
    last = path.tip[path.block == path.block[-1]]
    assert np.ptp(last, axis=0) == pytest.approx(0.0, abs=1e-9) and len(last) > 1
