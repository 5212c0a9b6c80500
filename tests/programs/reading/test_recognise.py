"""Controllers are told by what stands in the program."""

from __future__ import annotations

import pytest

from tests.support.growth import order_of_growth
from toolpace import read_text
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.controllers.recognise import recognise
from toolpace.programs.reading.source import Source


@pytest.mark.parametrize(
    ("text", "name", "why"),
    [
        ("%\nO ENTER OP AND LAST 3 DIGITS\nG90 G53 G00 Z0.0\nN1 T008 M06\nG43 G00 X1. H008", "haas", "header"),
        ("G00 G90 G154 P5 X0\nG254\nM31", "haas", "G154"),
        ("O0001\nG91 G28 Z0.0\nG05.1 Q1\nG43.4 H1", "fanuc", "G05.1 Q"),
        ("G54.1 P3\nG68.2 X0 Y0 Z0 I0 J30. K0\nG53.1", "fanuc", "of Fanuc"),
        ("#1=0\nWHILE [#1 LT 5] DO1\nEND1\nIF[#1EQ5]GOTO10", "fanuc", "GOTO"),
        ("o100 sub\nG1 X#1\no100 endsub\no100 call [3]", "linuxcnc", "O-words"),
        ("M428\nG1 X1", "linuxcnc", "kinematics"),
        ("#<depth>=5\nG1 Z#<depth>", "linuxcnc", "named variables"), ("G21 G64 P0.01\nG0 X1", "linuxcnc", "tolerance"),
        ("%PM1\nN10 G54 I1\nN20 G7 A5=0.0 B5=0.0 L1=1\nN30 G174", "millplus", "MillPlus"),
        ("O0001 (P)\n(MACHINE: HAAS VF-4 5-AXIS)\nG91 G28 Z0.", "haas", "header"),
        ("(Exported by FreeCAD)\n(Post Processor: linuxcnc_post)\nG17 G54", "linuxcnc", "header"),
        ("O0001\n(CONTROL: FANUC 31I)\nG154 P5", "fanuc", "header"),
        ("O0001\n(MACHINE - MAZAK VTC-800)\nG54.1 P3", "mazak", "header"),
        ("(the HAAS is busy)\nG1 X1", "iso", "nothing"),
        ("G21 G90\nG0 X0 Y0\nG1 X1 F100", "iso", "nothing"), ("(G254 M428 O100 SUB)\nG1 X1", "iso", "nothing"),
    ],
)  # fmt: skip
def test_signs_tell_the_controller_and_the_reason_is_said(text, name, why):
    found, reason, _ = recognise(Source.from_text(text))
    assert found.name == name and why in reason


@pytest.mark.parametrize("first", ["%NEU G71 *", "%NEU G70", "\n%3803 G71*"])
@pytest.mark.parametrize("controller", [None, "fanuc"])
def test_din_iso_of_heidenhain_is_told_and_refused(first, controller):
    """There G54 X Y is a shift of the datum: it was run as a motion."""
    text = f"{first}\nN10 G00 G90 X+0 Y+0 Z+100\nN20 G54 X+10 Y+5\nN30 G01 X+5 F100\nN40 M30\n"
    with pytest.raises(ProgramError, match=r"DIN/ISO for Heidenhain's controls .*post it as Klartext"):
        read_text(text, name="part.nc", controller=controller)
    assert len(read_text(text.replace(first, "%").replace("G54 ", ""), name="part.nc", controller=controller)) > 1


@pytest.mark.parametrize(
    ("name", "controller"),
    [("a.ngc", "linuxcnc"), ("A.MPF", "sinumerik"), ("a.eia", "mazak"), ("a.nc", "iso"), ("a.iso", "iso")],
)
def test_the_name_tells_where_the_program_does_not(name, controller):
    assert recognise(Source.from_text("G0 X0\n", name)).controller.name == controller


@pytest.mark.parametrize(
    "text",
    [
        "G91 G10 L2 P1 X5\nG90 G4 P2", "O100\nM98 P200\nM99", "G91 G28 Z0\nT01 M06", "(r1= 5 cr=2)\nG2 X1 I5 (ap=1)",
        "#1=5 (radius r1=#1, TRANS X1)\nG1 X#1", "; GOTOF END, MSG (here)\nG1 X1",
    ],
)  # fmt: skip
def test_what_another_control_has_as_well_does_not_outweigh_the_name(text):
    assert recognise(Source.from_text(text, "part.ngc")).controller.name == "linuxcnc"


@pytest.mark.parametrize(
    "comment", ["(G154 P5)", "(see (G254) there)", "X1. (o100 sub", "; G43.4 H1", "N5 (R1=5)", "G1 X1;CYCLE800"]
)
def test_comments_are_no_signs(comment):
    found = recognise(Source.from_text(f"G21 G90\n{comment}\nG1 X1 F100\n", "part.nc"))
    assert found.controller.name == "iso"


def test_brackets_of_sinumerik_are_no_comments():
    text = "N10 MSG(\"here\")\nN20 X=AC(5) Y=IC(R2)\nN30 CYCLE81(10,0,2,-5)\n"
    assert recognise(Source.from_text(text, "part.nc")).controller.name == "sinumerik"


@pytest.mark.parametrize(
    ("text", "others"),
    [
        ("G21 G90\nG1 X1 F100", {"fanuc", "haas", "linuxcnc"}),
        ("T01 M06\nG91 G28 Z0", {"haas", "linuxcnc"}),
        ("G05.1 Q1\nO1234\nG43.4 H1", set()), ("o<hole> sub\no<hole> endsub", set()), ("%_N_A_MPF\nTRAORI", set()),
    ],
)  # fmt: skip
def test_others_are_those_whose_signs_weigh_about_as_much(text, others):
    assert {other.name for other in recognise(Source.from_text(text)).others} == others


@pytest.mark.parametrize(
    "piece", ["G74 X1 ", " ", "O ", "N1 ", "(", "G91 G", "IF[", "#<", "T0", "\n", "A5", "X1", "N1G1X1.5 Y-2 "]
)
def test_telling_takes_time_in_proportion(piece):
    def tell(text):
        recognise(Source.from_text("G0" + text))

    few, many = (piece * (size // len(piece)) for size in (50_000, 200_000))
    assert order_of_growth(tell, few, many, 4.0) < 1.6
