"""M120 of Klartext and CDON of a Sinumerik leave out loops of the way: contours that have one are refused there."""

from __future__ import annotations

import pytest

from tests.support.compensated import read
from toolpace.common.errors import ProgramError

KEYHOLE = [(0, 20), (-20, 20), (-20, 50), (26, 50), (26, 20), (6, 20), (6, 0)]
"""Its throat is 6 mm wide, the tool 8: behind the throat the way comes across the one into it."""
WIDE = [(0, 20), (-20, 20), (-20, 50), (30, 50), (30, 20), (10, 20), (10, 0)]


def klartext(points: list[tuple[int, int]], words: str) -> str:
    blocks = "\n".join(f"L X{x:+} Y{y:+}" for x, y in points)
    return f"L X+30 Y-20 Z+0 R0 FMAX\nL X+0 Y+0 {words} F500\n{blocks}\nL X+30 Y-20 R0\nM30\nEND PGM A MM\n"


def sinumerik(points: list[tuple[int, int]], words: str) -> str:
    blocks = "\n".join(f"X{x} Y{y}" for x, y in points)
    return f"G0 X30 Y-20 Z0\n{words} G42 G1 X0 Y0 F500\n{blocks}\nG40 X30 Y-20\nM30\n"


@pytest.mark.parametrize(
    ("control", "text"),
    [
        ("heidenhain", klartext(KEYHOLE, "RR M120 LA10")),
        ("heidenhain", klartext(KEYHOLE, "RR").replace("L X+0 Y+20", "L X+0 Y+20 M120 LA10")),
        ("sinumerik", sinumerik(KEYHOLE, "CDON G450")),
        ("sinumerik", sinumerik(KEYHOLE, "CDON G451")),
        # a circle of 10 mm that is left for a line across its own beginning
        ("sinumerik", "CDON G0 X0 Y-30\nG41 G1 X10 Y-20 F500\nX10 Y0\nG2 X20 Y-10 I10 J0\nG1 X-20\nG40 Y-50\nM30\n"),
    ],
)
def test_a_loop_is_refused(control, text):
    with pytest.raises(ProgramError, match=r"part\.nc:\d+: the way of the tool's centre crosses itself"):
        read(text, control)


CLOSED = "G41 G1 X-10 Y-10 F500\nG3 X0 Y0 CR=10\nG1 Y30\nX30\nY-30\nX0\n{}G40 G1 X-20 Y0\nM30\n"


@pytest.mark.parametrize(
    ("control", "text"),
    [
        ("heidenhain", klartext(KEYHOLE, "RR")),
        ("heidenhain", klartext(KEYHOLE, "RR M120 LA3")),
        ("heidenhain", klartext(KEYHOLE, "RR M120 LA10").replace("L X-20 Y+50", "L X-20 Y+50 M120")),
        ("heidenhain", klartext(WIDE, "RR M120 LA10")),
        ("sinumerik", sinumerik(KEYHOLE, "CDOF G450")),
        ("sinumerik", sinumerik(WIDE, "CDON G451")),
        # outlines that arcs lead onto and off: their ends meet, and overlap
        ("sinumerik", "CDON G0 X-20 Y0\n" + CLOSED.format("Y0\nG3 X-10 Y10 CR=10\n")),
        ("sinumerik", "CDON G0 X-20 Y0\n" + CLOSED.format("Y2\nG3 X-10 Y12 CR=10\n")),
        ("sinumerik", "CDON G0 X0\nG41 G1 X10 Y-10 F500\nG3 X20 Y0 CR=10\nG3 I-20\nX10 Y10 CR=10\nG40 G1 X0\nM30\n"),
    ],
)  # fmt: skip
def test_other_contours_are_read(control, text):
    assert len(read(text, control).tip) > 8


def test_r0_ends_looking_ahead():
    text = klartext(WIDE, "RR M120 LA10").replace("M30\nEND PGM A MM\n", "")
    assert len(read(text + klartext(KEYHOLE, "RR"), "heidenhain").tip) > 16
