"""Tools, stock and spindle speed as programs tell them: TLDATA, CUTTER, TOOL DEF, BLK FORM, WORKPIECE, S, M3, M4."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.programs.reading import read_text
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.programs.stock_figures import WorkpieceFigures
from toolpace.programs.tool_figures import ToolFigures

CLS = """TOOL PATH/{name},TOOL,{tool}
{shape}
MSYS/0.0000,0.0000,0.0000,1.0000000,0.0000000,0.0000000,0.0000000,1.0000000,0.0000000
LOADTL/1
RAPID
GOTO/0.0000,0.0000,5.0000
FEDRAT/MMPM,250.0000
GOTO/0.0000,0.0000,0.0000
GOTO/20.0000,0.0000,0.0000
END-OF-PATH
"""


def told(shape: str) -> tuple[ToolFigures | None, tuple[str, ...]]:
    path = read_text(CLS.format(name="A", tool="MILL", shape=shape), dialect="apt")
    return path.operations[0].figures, path.assumed


@pytest.mark.parametrize(
    "shape, figures",
    [
        # a face mill, a bull-nose mill and a spot drill of three programs of NX
        ("TLDATA/MILL,125.0000,1.0000,50.0000,0.0000,0.0000", ToolFigures("bull", 0.125, 0.001, stick_out=0.05)),
        ("TLDATA/MILL,32.0000,5.0000,75.0000,0.0000,0.0000", ToolFigures("bull", 0.032, 0.005, stick_out=0.075)),
        (
            "TLDATA/MILL,30.0000,0.0000,30.0000,0.0000,45.0000",
            ToolFigures("chamfer", 0.03, point_angle=0.5 * math.pi, stick_out=0.03),
        ),
        ("TLDATA/MILL,3.1750,0.0000,50.0000, 0.0000,0.0000", ToolFigures("flat", 0.003175, stick_out=0.05)),
        ("TLDATA/MILL,10.0,5.0,50.0,0.0,0.0", ToolFigures("ball", 0.01, stick_out=0.05)),
        ("TLDATA/MILL,2.0,1.0,50.0,3.0,0.0", ToolFigures("ball", 0.002, taper=math.radians(3), stick_out=0.05)),
        (
            "TLDATA/MILL,4.0,0.5,50.0,7.0,0.0",
            ToolFigures("taper", 0.004, 0.0005, taper=math.radians(7), stick_out=0.05),
        ),
        (
            "TLDATA/DRILL,MILL,10.0000,0.0000,80.0000,118.0000,35.0000",
            ToolFigures("drill", 0.01, point_angle=math.radians(118), stick_out=0.08, flute_length=0.035),
        ),
        ("CUTTER/12.0", ToolFigures("flat", 0.012)),
        ("CUTTER/12.0,6.0", ToolFigures("ball", 0.012)),
        ("CUTTER/12.0,2.0,4.0,2.0,0.0,0.0,50.0", ToolFigures("bull", 0.012, 0.002, stick_out=0.05)),
    ],
)
def test_the_shape_of_a_tool_from_cutter_location_data(shape, figures):
    found, assumed = told(shape)
    for key in ("kind", "teeth", "flute_length", "stick_out"):
        value, wanted = getattr(found, key), getattr(figures, key)
        assert value == wanted or value == pytest.approx(wanted)
    for key in ("diameter", "corner_radius", "taper", "point_angle"):
        assert getattr(found, key) == pytest.approx(getattr(figures, key))
    assert "program:2" in found.source and not any("is not read" in each for each in assumed)


@pytest.mark.parametrize(
    "shape",
    [
        "TLDATA/TCUTTER,MILL,50.0,1.0,5.0,10.0",
        "TLDATA/MILL,10.0,5.0",
        "TLDATA/MILL,10.0,7.0,50.0,0.0,0.0",
        "TLDATA/MILL,-10.0,0.0,50.0,0.0,0.0",
        "TLDATA/MILL,10.0,1.0,50.0,0.0,45.0",
        "TLDATA/MILL,10.0,3.0,50.0,0.0,0.0,0.5,3.0",
        "CUTTER/DISPLY,TOOL",
    ],
)
def test_other_shapes_are_passed_over_and_said(shape):
    found, assumed = told(shape)
    assert found is None and any("is not read: write it on the set-up sheet" in each for each in assumed)


def test_each_operation_has_its_tool_and_each_length_its_unit():
    text = "UNITS/INCHES\n" + CLS.format(name="A", tool="M1", shape="TLDATA/MILL,0.5,0.0,2.0,0.0,0.0")
    text += CLS.format(name="B", tool="M2", shape="TLDATA/MILL,0.25,0.125,2.0,0.0,0.0").replace("LOADTL/1", "LOADTL/2")
    text += CLS.format(name="C", tool="M3", shape="$$ nothing").replace("LOADTL/1", "LOADTL/3")
    first, second, third = read_text(text, dialect="apt").operations
    assert first.figures.diameter == pytest.approx(0.0127) and first.figures.kind == "flat"
    assert second.figures.kind == "ball" and third.figures is None
    creo = "UNITS/MM\nCUTTER/12\nLOADTL/1\nGOTO/0,0,5\nFEDRAT/100,MMPM\nGOTO/0,0,0\nLOADTL/2\nGOTO/5,0,0\nFINI\n"
    first, second = read_text(creo, dialect="apt").operations
    assert (first.tool, first.figures.diameter, second.tool, second.figures) == ("1", 0.012, "2", None)


KLARTEXT = """0 BEGIN PGM A MM
1 BLK FORM 0.1 Z X+0 Y-10 Z-40
2 BLK FORM 0.2 X+100 IY+100 Z+0
3 TOOL DEF 3 L+30 R+5,5
4 TOOL CALL 3 Z S5000
5 L X+0 Y+0 Z+5 R0 FMAX M3
6 L Z-5 F300
7 L X+50 F500
8 TOOL CALL 3 Z S8000
9 L X+20 M4
10 L X+10 M5
11 L X+5
12 END PGM A MM
"""


def test_klartext_tells_stock_tool_and_spindle():
    path = read_text(KLARTEXT)
    stock = path.workpiece.stock
    assert np.allclose(stock.solid.box, ((0.0, -0.01, -0.04), (0.1, 0.09, 0.0))) and not stock.guessed
    assert "program:3" in stock.solid.source and stock.uncertainty == 0.1e-3
    figures = path.operations[0].figures
    assert (figures.kind, figures.diameter) == ("flat", 0.011) and "flat end mill" in figures.assumed[0]
    assert path.spindle * 60 == pytest.approx([5000.0, 5000.0, 5000.0, -8000.0, 0.0, 0.0])


@pytest.mark.parametrize(
    "block, cylinder",
    [
        ("BLK FORM CYLINDER Z R50 L105 DIST+5", ((0.0, 0.0, -0.1), (0.0, 0.0, 0.005), 0.1)),
        ("BLK FORM CYLINDER X D50 L20", ((-0.02, 0.0, 0.0), (0.0, 0.0, 0.0), 0.05)),
    ],
)
def test_a_cylinder_of_klartext(block, cylinder):
    text = KLARTEXT.replace("BLK FORM 0.1 Z X+0 Y-10 Z-40", block).replace("2 BLK FORM 0.2 X+100 IY+100 Z+0\n", "")
    path = read_text(text)
    assert np.allclose(np.hstack(path.workpiece.stock.solid.cylinder), np.hstack(cylinder))
    assert any("not confirmed" in each for each in path.assumed)


@pytest.mark.parametrize(
    "block",
    [
        "BLK FORM CYLINDER Z R50 L105 DIST+5 RI10",
        "BLK FORM CYLINDER Z R0 L105",
        "BLK FORM ROTATION Z DIM_D LBL10",
        'BLK FORM FILE "TNC:\\nc_prog\\blank.stl"',
        "BLK FORM 0.1 Z X+0 Y-10",
        "BLK FORM 0.1 Z X+200 Y-10 Z-40",
        "BLK FORM 0.1 Z X+Q50 Y-10 Z-40",
        "BLK",
    ],
)
def test_other_blanks_of_klartext_are_passed_over_and_said(block):
    path = read_text(KLARTEXT.replace("BLK FORM 0.1 Z X+0 Y-10 Z-40", block))
    assert path.workpiece == WorkpieceFigures() and any("this BLK FORM is not read" in each for each in path.assumed)
    assert path.skipped["BLK"] and "BLK" not in read_text(KLARTEXT).skipped
    assert np.array_equal(path.tip, read_text(KLARTEXT).tip)


SINUMERIK = "N10 G17 G90\n{}\nG54\nT=\"A\"\nM6\nS3000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F200\nM4\nX10\nM30\n"


@pytest.mark.parametrize(
    "block, box",
    [
        # 2 of allowance, 184 by 170 wide and 30 high, as a comment in that program says
        ('WORKPIECE(,"",,"BOX",0,2,-30,-80,-2,-2,184,170)', ((-2, -2, -28), (182, 168, 2))),
        ('WORKPIECE(,,,"BOX",112,0,-50,-80,-60,60,60,-60)', ((-60, -60, -50), (60, 60, 0))),
        ('WORKPIECE(,"",,"BOX",112,0,-51,,50,25,-50,-25)', ((-50, -25, -51), (50, 25, 0))),
    ],
)
def test_the_box_of_sinumerik(block, box):
    path = read_text(SINUMERIK.format(block), controller="sinumerik")
    assert np.allclose(1e3 * np.array(path.workpiece.stock.solid.box), box) and "WORKPIECE" not in path.skipped
    assert path.spindle * 60 == pytest.approx([3000.0, 3000.0, -3000.0])
    sheet = setup_of_text("[offsets.G54]\nX = 10\n")
    assert read_text(SINUMERIK.format(block), controller="sinumerik", setup=sheet).workpiece.stock.solid.frame == "G54"


def test_other_blanks_of_sinumerik():
    turned = read_text(SINUMERIK.format('WORKPIECE(,,,"CYLINDER",192,5,-100,-100,50)'), controller="sinumerik")
    assert np.allclose(np.hstack(turned.workpiece.stock.solid.cylinder), [0, 0, -0.1, 0, 0, 0.005, 0.05])
    for arguments in (
        ',,,"RECTANGLE",64,0,-20,-80,100,100', ',,,"BOX",80,0,-50,-80,-60,60,60,-60', ',,,"BOX",112,0,-50',
        ',,,"BOX",112,0,0,-80,0,0,60,60', ',,,"CYLINDER",64,0,-20,-80,-5', ',,,"CYLINDER",64,0,-20,-80,50,40', ",,,7",
    ):  # fmt: skip
        path = read_text(SINUMERIK.format(f"WORKPIECE({arguments})"), controller="sinumerik")
        assert path.workpiece == WorkpieceFigures() and any("WORKPIECE of this form" in each for each in path.assumed)
        assert path.skipped["WORKPIECE"] == 1
    assert read_text(SINUMERIK.format("WORKPIECE()"), controller="sinumerik").workpiece == WorkpieceFigures()


@pytest.mark.parametrize("controller", ["fanuc", "haas", "linuxcnc", "mazak", "iso"])
def test_the_spindle_of_word_addresses(controller):
    text = "G21 G90 G54\nT1 M6\nS6000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F200\nS4000\nX10\nM4\nX20\nM5\nX30\nM30\n"
    path = read_text(text, controller=controller)
    assert path.spindle * 60 == pytest.approx([6000.0, 6000.0, 4000.0, -4000.0, 0.0])
    assert path.spindle_of(path.operation, path.block) * 60 == pytest.approx(path.spindle * 60)
    assert np.isnan(path.spindle_of([0, 3], [1, 10])).all()
    without = text.replace("S6000 ", "").replace("S4000\n", "")
    assert np.isnan(read_text(without, controller=controller).spindle[:3]).all()


def test_the_spindle_of_cutter_location_data():
    text = CLS.format(name="A", tool="M", shape="SPINDL/RPM,3000,CCLW").replace("GOTO/20", "SPINDL/OFF\nGOTO/20")
    assert read_text(text, dialect="apt").spindle * 60 == pytest.approx([-3000.0, -3000.0, 0.0])
    assert np.isnan(read_text(CLS.format(name="A", tool="M", shape="SPINDL/SFM,300"), dialect="apt").spindle).all()


def test_points_between_have_the_speed_of_their_block():
    path = read_text("G21 G90 G17\nS6000 M3\nG0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F600\nS3000\nG3 X0 Y0 I-5 J0\nM30\n")
    assert len(path) > 20 and set((path.spindle * 60).round(9)) == {6000.0, 3000.0}
    half = path.part(5, len(path) - 5)
    assert np.array_equal(half.spindle, path.spindle[5:-4])
