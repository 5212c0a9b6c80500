"""Corners that a block asks for at its end, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.controllers import read_for
from tests.support.sinumerik import read
from toolpace.common.errors import ProgramError

START = "G90 G21 G94 G17 F600\nG0 X0 Y0 Z0\n"


def path_of(controller, body):
    return read(body.replace("\nM30", "")) if controller == "sinumerik" else read_for(controller, START + body)


@pytest.mark.parametrize(
    ("controller", "word"), [("fanuc", ",R5."), ("haas", ",R5."), ("mazak", ",R5."), ("sinumerik", "RND=5")]
)
def test_a_corner_is_rounded_by_a_tangent_arc(controller, word):
    """Fanuc B-63944EN, "Optional chamfering and corner R"; Siemens NC Programming, "Chamfer, rounding": RND."""
    tip = path_of(controller, f"G1 X40 {word}\nY30\nM30").tip[1:] * 1e3
    assert np.allclose(tip[0], [35, 0, 0]) and np.allclose(tip[-2:], [[40, 5, 0], [40, 30, 0]])
    assert np.allclose(np.linalg.norm(tip[:-1, :2] - [35, 5], axis=1), 5)


@pytest.mark.parametrize(("controller", "word"), [("fanuc", ",C5."), ("haas", ",C5."), ("sinumerik", "CHR=5")])
def test_a_corner_is_cut_by_its_sides(controller, word):
    """Fanuc: ,C is the distance from the corner to both ends of the chamfer; so is CHR of Sinumerik."""
    tip = path_of(controller, f"G1 X40 {word}\nY30\nM30").tip[1:] * 1e3
    assert np.allclose(tip, [[35, 0, 0], [40, 5, 0], [40, 30, 0]])


def test_chf_is_the_length_of_the_edge():
    """Siemens NC Programming, "Chamfer, rounding": CHF is the length of the chamfer itself."""
    tip = read("G1 X40 CHF=5\nX40 Y30").tip[1:] * 1e3
    assert np.linalg.norm(tip[1] - tip[0]) == pytest.approx(5) and tip[0][0] == pytest.approx(40 - 5 / np.sqrt(2))


def test_rndm_rounds_every_corner_until_zero():
    """Siemens NC Programming, "Chamfer, rounding": RNDM is modal, RNDM=0 ends it."""
    tip = read("RNDM=5 G1 X40\nY30\nX0 RNDM=0\nY60").tip * 1e3
    assert np.hypot(*(tip[:, :2] - [40, 0]).T).min() > 2 and np.hypot(*(tip[:, :2] - [40, 30]).T).min() > 2
    assert (tip[-2] == [0, 30, 0]).all()


@pytest.mark.parametrize(
    "body", ["G1 X40. ,R5.\nG2 X50. Y10. R10.\nM30", "G1 X40. ,R5.\nG1 Z5.\nM30", "G1 X40. ,R5.\nM30"]
)
def test_a_corner_that_is_none_of_two_lines_is_refused(body):
    with pytest.raises(ProgramError, match=",R is not read: it is read between two straight lines"):
        read_for("fanuc", START + body)


@pytest.mark.parametrize(("controller", "word"), [("fanuc", ",R50."), ("sinumerik", "RND=50")])
def test_a_corner_that_is_larger_than_its_lines_is_an_error(controller, word):
    with pytest.raises(ProgramError, match="takes 50 mm of both lines"):
        path_of(controller, f"G1 X40 {word}\nY30\nM30")


def test_other_words_behind_a_comma_and_corners_of_other_controls_stay_refused():
    for controller, word in (("fanuc", ",A5."), ("linuxcnc", ",R5")):
        with pytest.raises(ProgramError, match="let the CAM system write the corner out"):
            read_for(controller, START + f"G1 X40 {word}\nY30\nM30")


@pytest.mark.parametrize(
    ("controller", "word", "change"),
    [("fanuc", ",R2.", "G52 X90."), ("haas", ",C2.", "G52 X90."), ("sinumerik", "RND=2", "TRANS X90")],
)
def test_a_corner_over_a_change_of_coordinates_is_refused(controller, word, change):
    """The way before was taken in the new coordinates, and the corner lay beside its lines."""
    with pytest.raises(ProgramError, match="is not read: it is read between two straight lines of the plane"):
        path_of(controller, f"G1 X10 {word}\n{change}\nG1 Y20\nM30")
