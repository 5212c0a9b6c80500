"""Bodies in the frame of the part: where set-up and placement put them, the guessed stock, and stock off the path."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from toolpace.common.errors import UnitWarning, UsageError
from toolpace.cutting.stock.solids import Body, body_of, check_stock_place, guessed_stock
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.setup_file import setup_of_text
from toolpace.programs.stock_figures import Solid
from toolpace.programs.tool_figures import ToolFigures

LOW, HIGH = (0.0, 0.0, -0.02), (0.1, 0.06, 0.0)


def volume(triangles: np.ndarray) -> float:
    return float(np.einsum("ij,ij->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2]))) / 6.0


def test_a_body_lies_where_its_placement_says():
    plain = body_of(Solid(box=(LOW, HIGH)), None, SetUp())
    assert np.array_equal(plain.box, (LOW, HIGH)) and volume(plain.triangles()) == pytest.approx(1.2e-4)
    # turned over about X, as for the second clamping: still a box
    over = body_of(Solid(box=(LOW, HIGH), origin=(0.0, 0.06, 0.0), z=(0.0, 0.0, -1.0)), None, SetUp())
    assert over.box[0] == pytest.approx([0.0, 0.0, 0.0]) and over.box[1] == pytest.approx([0.1, 0.06, 0.02])
    s = math.sqrt(0.5)
    turned = body_of(Solid(box=(LOW, HIGH), x=(s, s, 0.0)), None, SetUp())
    assert turned.box is None and turned.volume == pytest.approx(1.2e-4)
    assert turned.bounds[1] == pytest.approx([0.1 * s, 0.16 * s, 0.0])
    lying = Solid(cylinder=(LOW, (0.0, 0.0, 0.02), 0.05), x=(0.0, 0.0, 1.0), z=(1.0, 0.0, 0.0))
    cylinder = body_of(lying, None, SetUp())
    assert cylinder.bounds[0] == pytest.approx([-0.02, -0.025, -0.025])
    assert cylinder.bounds[1] == pytest.approx([0.02, 0.025, 0.025])
    assert cylinder.volume == pytest.approx(math.pi * 0.025**2 * 0.04)
    assert volume(cylinder.triangles()) == pytest.approx(cylinder.volume, rel=2e-4)


@pytest.mark.parametrize("machine", ["xyzac-trunnion", "xyzbc-head", "xyzab-trunnion-inch"])
def test_a_body_in_a_work_offset_lies_where_a_program_in_it_goes(machine):
    """The corners of a box are where blocks of the program put the tip, with the rotary joints of the offset."""
    machine = Machine.load(machine)
    letters = [machine.joints[i] for i in machine.rotary]
    setup = setup_of_text(
        f"[offsets.G54]\nX = -120\nY = 15\nZ = -300\n[offsets.G55]\nX = -80\nY = 7\nZ = -310\n{letters[1]} = 90\n"
        f"[tools.1]\nlength = {machine.tool_length * 1e3}\n"
    )
    for offset in ("G54", "G55"):
        program = f"T1 M6\n{offset} G43 H1\nG0 X0 Y0 Z-20 {letters[0]}0 {letters[1]}0\nG1 X100 Y60 Z0 F600\nM30\n"
        tip = read_text(program, machine, controller="fanuc", setup=setup).tip
        body = body_of(Solid(box=(LOW, HIGH), frame=offset), machine, setup)
        low, high = body.bounds
        assert np.minimum(tip[0], tip[-1]) == pytest.approx(low, abs=1e-12)
        assert np.maximum(tip[0], tip[-1]) == pytest.approx(high, abs=1e-12) and body.volume == pytest.approx(1.2e-4)
    with pytest.raises(UsageError, match=r"G57 is not among G54, G55; list \[offsets.G57\]"):
        body_of(Solid(box=(LOW, HIGH), frame="G57"), machine, setup)
    # without offsets on the sheet each of them is the frame of the part
    assert np.array_equal(body_of(Solid(box=(LOW, HIGH), frame="G57"), machine, SetUp()).box, (LOW, HIGH))


PROGRAM = "T1 M6\nG0 X0 Y0 Z50\nZ2\nG1 Z-5 F300\nX80 F900\nG0 Z50\nT2 M6\nG0 X10 Y30\nG1 Z-3 F300\nX20\nG0 Z50\nM30\n"


def test_the_guess_is_the_box_around_all_moves_at_feed():
    toolpath = read_text(PROGRAM)
    figures = [ToolFigures("flat", 0.012), ToolFigures("ball", 0.006)]
    stock = guessed_stock(toolpath, figures)
    low, high = stock.solid.box
    # the second tool feeds from Z50 on
    assert low == pytest.approx((-0.006, -0.006, -0.005)) and high == pytest.approx((0.086, 0.033, 0.053))
    assert stock.guessed
    with pytest.raises(UsageError, match="no move at feed"):
        guessed_stock(read_text("G0 X0 Y0 Z0\nX10\nM30\n"), [None])
    with pytest.raises(UsageError, match=r"\[tools.N\] diameter"):
        guessed_stock(read_text("G0 X0 Y0 Z0\nG1 X10 F100\nM30\n"), [None])
    across = "G43.4\nG0 X0 Y0 Z0 A90 C0\nG1 X10 F100\nM30\n"
    tilted = read_text(across, Machine.load("xyzac-trunnion"), controller="fanuc")
    low, high = guessed_stock(tilted, [ToolFigures("flat", 0.012)]).solid.box
    axis = tilted.axis[0]
    assert high[2] - low[2] == pytest.approx(0.012) and abs(axis[2]) < 1e-12
    assert high[1] - low[1] == pytest.approx(0.006)


def test_stock_off_the_path_and_of_another_unit(tmp_path):
    toolpath, figures = read_text(PROGRAM), [ToolFigures("flat", 0.012)] * 2
    check_stock_place(Body(box=(np.array(LOW), np.array(HIGH))), toolpath, figures)
    away = Body(box=(np.array([0.2, 0.0, -0.02]), np.array([0.3, 0.06, 0.0])))
    with pytest.raises(UsageError) as caught:
        check_stock_place(away, toolpath, figures)
    message = str(caught.value)
    assert "114 mm away" in message and "[200, 0, -20]" in message and "check its place" in message
    box = trimesh.creation.box((100.0, 60.0, 20.0))
    box.apply_translation((50.0, 20.0, -10.0))
    box.apply_scale(1.0 / 25.4)
    box.export(tmp_path / "stock.stl")
    solid = Solid(mesh=tmp_path / "stock.stl")
    with pytest.warns(UnitWarning, match=r'3.937 mm long, .* is it in inches\? Then write mesh_unit = "in"'):
        check_stock_place(body_of(solid, None, SetUp()), toolpath, figures)
    in_inches = body_of(Solid(mesh=tmp_path / "stock.stl", mesh_unit="in"), None, SetUp())
    assert in_inches.bounds[1] == pytest.approx([0.1, 0.05, 0.0], abs=1e-7)
    check_stock_place(in_inches, toolpath, figures)
    box.apply_translation((0.0, 500.0, 0.0))
    box.export(tmp_path / "stock.stl")
    with pytest.raises(UsageError, match="is it in inches"):
        check_stock_place(body_of(solid, None, SetUp()), toolpath, figures)
