"""Tools, stock, part and fixtures on a set-up sheet: what is read and written, and what contradicts itself."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.programs.reading import read_text
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.findings import Used
from toolpace.programs.reading.setup_file import (
    load_setup,
    setup_of_text,
    setup_sheet,
    setup_text,
    with_program_figures,
)
from toolpace.programs.stock_figures import Solid, StockFigures, WorkpieceFigures
from toolpace.programs.tool_figures import KINDS, Frustum, ToolFigures

MM = 1e-3
SHEET = """
[tools.1]
kind = "bull"
diameter = 12
corner_radius = 1
flute_length = "26mm"
teeth = 3
pitch = [118, 122, 120]
helix = "38deg"
runout = "20um"
stick_out = 40
shank = [[5, 12, 11.5], [9, 11.5, 11.5]]
holder = [[40, 27, 30], [20, 50, 50]]
material = "carbide"
spindle_speed = 8000
spindle = "counterclockwise"
[stock]
box = [[-10, -10, -20], [60, 40, 0]]
kind = "sawn"
[finished_part]
mesh = "part.stl"
tolerance = 0.05
[fixtures.vice]
box = [[-40, -20, -60], [100, 60, -20]]
origin = [0, 0, "1in"]
x = [0, 1, 0]
"""


def test_what_a_sheet_tells_of_the_cut(tmp_path):
    (tmp_path / "sheet.toml").write_text(SHEET)
    setup = load_setup(tmp_path / "sheet.toml")
    tool = setup.figures_of("01")
    assert tool == ToolFigures(
        "bull",
        0.012,
        0.001,
        flute_length=26 * MM,
        teeth=3,
        pitch=tuple(math.radians(each) for each in (118, 122, 120)),
        helix=math.radians(38),
        runout=0.5 * (20 * 1e-6),
        stick_out=0.04,
        shank=(Frustum(5 * MM, 12 * MM, 11.5 * MM), Frustum(9 * MM, 11.5 * MM, 11.5 * MM)),
        holder=(Frustum(0.04, 0.027, 0.03), Frustum(0.02, 0.05, 0.05)),
        material="carbide",
        spindle_speed=8000 / 60,
        clockwise=False,
    )
    assert "sheet.toml: [tools.1]" in tool.source and tool.assumed == ()
    assert setup.tools["1"] == Tool(None, 0.006, 0.001, tool) and setup.figures_of("") is tool
    workpiece = setup.workpiece
    assert workpiece.stock == StockFigures(Solid(box=((-0.01, -0.01, -0.02), (0.06, 0.04, 0.0))), 1e-3)
    assert workpiece.finished_part.mesh == tmp_path / "part.stl" and workpiece.gouge_tolerance == 0.05e-3
    ((name, vice),) = workpiece.fixtures
    assert name == "vice" and vice.origin == (0.0, 0.0, 0.0254) and vice.x == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    "text, cylinder",
    [
        ("{ diameter = 50, height = 40 }", ((0.0, 0.0, -0.04), (0.0, 0.0, 0.0), 0.05)),
        ("{ diameter = 50, height = 40, top = 35 }", ((0.0, 0.0, 0.035 - 0.04), (0.0, 0.0, 0.035), 0.05)),
        ("{ diameter = 50, from = [1, 2, 2], to = [1, 4, 2] }", ((0.001, 0.002, 0.002), (0.001, 0.004, 0.002), 0.05)),
    ],
)
def test_a_cylinder_is_told_in_two_ways(text, cylinder):
    solid = setup_of_text(f"[stock]\ncylinder = {text}\nuncertainty = 0.3\n").workpiece.stock
    assert solid.solid.cylinder == cylinder and solid.uncertainty == pytest.approx(0.3e-3)


def random_tool(r: np.random.Generator) -> ToolFigures:
    """Figures of all kinds that contradict nothing."""
    kind = KINDS[r.integers(len(KINDS))]
    diameter, flute, teeth = r.uniform(0.001, 0.06), r.uniform(0.002, 0.05), int(r.integers(1, 9))
    own = {
        "bull": {"corner_radius": diameter * r.uniform(0.01, 0.49)},
        "face": {"corner_radius": diameter * r.uniform(0.0, 0.1)},
        "taper": {"taper": r.uniform(0.01, 1.0), "corner_radius": diameter * r.uniform(0.0, 0.5)},
        "barrel": {"barrel_radius": diameter * r.uniform(0.6, 20)},
        "lens": {"barrel_radius": diameter * r.uniform(0.6, 20), "corner_radius": diameter * r.uniform(0.0, 0.5)},
        "drill": {"point_angle": r.choice([0.0, 2.0, 2.4])},
        "chamfer": {"point_angle": r.uniform(0.5, 2.5)},
    }.get(kind, {})
    if r.random() < 0.5:
        pitch = r.uniform(0.8, 1.2, teeth)
        own["pitch"] = tuple((pitch * math.tau / pitch.sum()).tolist())
    if r.random() < 0.5:
        own |= {"stick_out": flute + 0.05, "shank": (Frustum(0.02, *r.uniform(0.001, 0.02, 2).tolist()),)}
        own |= {"holder": (Frustum(0.03, 0.03, float(r.uniform(0.03, 0.06))),)}
    own = {key: float(value) if isinstance(value, np.floating) else value for key, value in own.items()}
    rest = {"helix": float(r.normal() * 0.2), "runout": float(diameter * 0.01 * r.random())}
    rest |= {"spindle_speed": float(r.uniform(1, 900)), "clockwise": bool(r.random() < 0.5), "material": "HSS"}
    return ToolFigures(kind, float(diameter), **own, **rest, flute_length=float(flute), teeth=teeth)


def test_a_sheet_is_written_so_that_it_reads_as_the_same_to_the_last_digit():
    r = np.random.default_rng(11)
    for _ in range(200):
        figures = random_tool(r)
        corner = figures.corner_radius if figures.kind in ("flat", "bull", "ball") else None
        radius = None if figures.kind in ("taper", "chamfer") else 0.5 * figures.diameter
        length = float(r.uniform(0.1, 0.3)) if r.random() < 0.5 else None
        if figures.corner_radius and corner is None:
            corner = figures.corner_radius
        a, b, c = (float(each) for each in r.normal(size=3))
        solids = [
            Solid(box=((-abs(a), b, c), (abs(a), b + 1.0, c + 0.1)), frame="G54"),
            Solid(cylinder=((a, b, c), (a, b, c + 1.0), abs(b)), origin=(c, b, a), x=(a, b, 0.0), z=(0.0, 0.0, 2.0)),
            Solid(mesh=Path("/parts/part 1.stl"), mesh_unit="in"),
        ]
        workpiece = WorkpieceFigures(StockFigures(solids[0], abs(a) / 50), solids[1], 1e-5, (("vice 1", solids[2]),))
        setup = SetUp(
            "set-up sheet", tools={"1": Tool(length, radius, corner, figures)}, workpiece=workpiece,
        )  # fmt: skip
        assert setup_of_text(setup_text(setup)) == setup
    guessed = replace(workpiece, stock=replace(workpiece.stock, guessed=True))
    assert "[stock]" not in setup_text(SetUp(workpiece=guessed))


TOLD = ToolFigures("bull", 12.7 * MM, 1.5 * MM, flute_length=38 * MM, source="part.apt:4")


def test_a_table_without_a_diameter_adds_to_what_the_program_tells():
    lines = (
        "teeth = 4\nstick_out = 60\nholder = [[40, 27, 30]]\nspindle_range = [4000, 9000]\nrunout = 0.02\n"
        'helix = 38\npitch = [80, 100, 85, 95]\nspindle = "counterclockwise"\ncutting_speed = 300\nlength = 120\n'
    )
    setup = setup_of_text("[tools.1]\n" + lines)
    found = setup.figures_of("1", TOLD)
    alone = setup_of_text("[tools.1]\ndiameter = 12.7\ncorner_radius = 1.5\nflute_length = 38\n" + lines)
    assert found == alone.figures_of("1") and found.teeth == 4 and found.source == "part.apt:4"
    assert (setup.tool("1").length, setup.tool("1").radius) == (120 * MM, None)
    assert setup.figures_of("1") is None and setup.figures_of("2", TOLD) is TOLD
    assert setup_of_text(setup_text(setup)) == setup
    filled = with_program_figures(setup, {"1": TOLD}, WorkpieceFigures())
    assert filled.figures_of("1") == found and setup_of_text(setup_text(filled)).figures_of("1") == found


def test_what_a_table_adds_goes_before_the_program_and_must_not_contradict_it():
    setup = setup_of_text("[tools.1]\nflute_length = 20\ncorner_radius = 2\nteeth = 3\n")
    found = setup.figures_of("1", TOLD)
    assert (found.flute_length, found.corner_radius, found.teeth) == (20 * MM, 2 * MM, 3)
    with pytest.raises(UsageError, match=r"part\.apt:4: flute_length of 38 mm is more than the stick_out of 30 mm"):
        setup_of_text("[tools.1]\nstick_out = 30\n").figures_of("1", TOLD)


@pytest.mark.parametrize(
    "text, words",
    [
        ("diameter = 12\nradius = 12", ["radius = 12", "diameter = 12", "correct one"]),
        ("diameter = 12000", ["diameter = 12000", "more than 500 mm", "unit"]),
        ('diameter = "12"', ["diameter", "has no unit"]),
        ("diameter = 0", ["diameter is 0 mm", "above 0"]),
        ('kind = "torus"\ndiameter = 12', ["kind = 'torus'", "flat, bull, ball"]),
        ("diameter = 12\ncorner_radius = 7", ["corner_radius of 7 mm", "half of the diameter of 12 mm"]),
        ('kind = "ball"\ndiameter = 12\ncorner_radius = 2', ["not that of a ball of 12 mm", "6 mm", '"bull"']),
        ('kind = "bull"\ndiameter = 12', ["give corner_radius"]),
        ('kind = "flat"\ndiameter = 12\ncorner_radius = 1', ["remove it", '"bull"']),
        ("diameter = 12\nflute_length = 40\nstick_out = 30", ["flute_length of 40 mm", "stick_out of 30 mm"]),
        ("diameter = 12\nshank = [[10, 12, 12]]", ["give flute_length"]),
        ("diameter = 12\nflute_length = 20\nshank_diameter = 10\nshank = [[10, 12, 12]]", ["keep one"]),
        ("diameter = 12\nflute_length = 20\nstick_out = 25\nshank = [[10, 12, 12]]", ["10 mm long", "only 5 mm"]),
        ("diameter = 12\nholder = [[10, 30, 30]]", ["give stick_out"]),
        ("diameter = 12\nstick_out = 30\nshank_diameter = 20\nholder = [[10, 16, 30]]", ["20 mm", "16 mm"]),
        ("diameter = 12\nholder = [10, 30, 30]", ["write each piece", "[[40, 12, 12]"]),
        ("diameter = 12\npitch = [120, 120, 110]", ["350 deg", "360"]),
        ("diameter = 12\nteeth = 2\npitch = [120, 120, 120]", ["3 angles", "teeth = 2"]),
        ("diameter = 12\nteeth = 2.5", ["teeth = 2.5", "whole number"]),
        ("diameter = 12\nteeth = 0", ["teeth = 0", "1 to 100"]),
        ("diameter = 12\nrunout = 3", ["runout is 1.5 mm", "at most 1.2 mm"]),
        ("diameter = 12\nhelix = 95", ["helix is 95 deg", "between -90 and 90"]),
        ('kind = "taper"\ndiameter = 12', ["give taper"]),
        ('kind = "flat"\ndiameter = 12\ntaper = 3', ["taper on", 'kind = "taper"']),
        ('kind = "barrel"\ndiameter = 12', ["give barrel_radius"]),
        ('kind = "lens"\ndiameter = 12', ["the end of a lens mill is an arc", "give barrel_radius"]),
        ('kind = "barrel"\ndiameter = 12\nbarrel_radius = 5', ["barrel_radius of 5 mm", "12 mm"]),
        ('kind = "chamfer"\ndiameter = 12', ["point_angle", "taper", "one of both"]),
        ('kind = "chamfer"\ndiameter = 12\npoint_angle = 90\ntaper = 45', ["one of both"]),
        ("diameter = 12\nspindle_speed = 0", ["0 rpm", "above zero"]),
        ('diameter = 12\nspindle = "M3"', ["spindle = 'M3'", "clockwise"]),
        ("diameter = 12\nflutelength = 3", ["'flutelength'", "flute_length"]),
        ("diameter = nan", ["not finite"]),
    ],
)
def test_a_tool_that_contradicts_itself_is_one_line(text, words):
    with pytest.raises(UsageError) as caught:
        setup_of_text(f"[tools.1]\n{text}\n", "sheet.toml")
    message = str(caught.value)
    assert message.startswith("sheet.toml: [tools.1]") and "\n" not in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    "text, words",
    [
        ('[stock]\nkind = "sawn"', ["[stock]", "tells no shape", "box"]),
        ("[stock]\nbox = [[0, 0, 0], [1, 1, 1]]\nmesh = 'a.stl'", ["box and mesh", "one of"]),
        ("[stock]\nbox = [0, 0, 1]", ["box = [0, 0, 1]", "[[0, 0, -20], [100, 60, 0]]"]),
        ("[stock]\nbox = [[0, 0, 0], [1, 1]]", ["not three numbers"]),
        ("[stock]\nbox = [[0, 0, 0], [1, 1, -1]]", ["least corner is not below", "least one first"]),
        ("[stock]\nbox = [[0, 0, 0], [1, 1, 0]]", ["box is empty"]),
        ("[stock]\nbox = [[0, 0, 0], [1e6, 1, 1]]", ["more than 30000 mm", "unit"]),
        ("[stock]\ncylinder = 3", ["cylinder", "{ diameter = 50"]),
        ("[stock]\ncylinder = { height = 3 }", ["no diameter"]),
        ("[stock]\ncylinder = { diameter = 3 }", ["from and to", "height"]),
        ("[stock]\ncylinder = { diameter = 3, height = 0 }", ["height = 0", "not above zero"]),
        ("[stock]\ncylinder = { diameter = 0, height = 3 }", ["cylinder is empty"]),
        ("[stock]\nmesh = ''", ["mesh = ''", "no text"]),
        ("[stock]\nmesh = 'a.stl'\nmesh_unit = 'mil'", ["mesh_unit = 'mil'", "mm"]),
        ("[stock]\nmesh = 'a.stl'\nx = [0, 0, 1]", ["right angle"]),
        ("[stock]\nmesh = 'a.stl'\nx = [0, 0, 0]", ["no length"]),
        ("[stock]\nmesh = 'a.stl'\nkind = 'rough'", ["kind = 'rough'", "machined, sawn"]),
        ("[stock]\nmesh = 'a.stl'\nuncertainty = -1", ["uncertainty is -1 mm", "between 0 and 100 mm"]),
        ("[stock]\nmesh = 'a.stl'\nframe = 'G55'\n[offsets.G54]\nX = 1", ["frame = 'G55'", "[offsets.G55]"]),
        ("[finished_part]\nmesh = 'a.stl'\ntolerance = -1", ["tolerance = -1", "below zero"]),
        ("[fixtures]\nvice = 3", ["vice = 3", "[fixtures.vice]"]),
        ("[fixtures.vice]\nboxes = 3", ["[fixtures.vice]", "did you mean 'box'"]),
    ],
)
def test_a_workpiece_that_is_none_is_one_line(text, words):
    with pytest.raises(UsageError) as caught:
        setup_of_text(text, "sheet.toml")
    message = str(caught.value)
    assert message.startswith("sheet.toml: [") and "\n" not in message
    for word in words:
        assert word in message


def test_what_is_not_told_is_assumed_and_said():
    setup = setup_of_text("[tools.1]\ndiameter = 6\ncorner_radius = 3\n[tools.2]\nkind = 'drill'\ndiameter = 3.3\n")
    ball, drill = setup.figures_of("1"), setup.figures_of("2")
    assert ball.kind == "ball" and "kind is not told" in ball.assumed[0]
    assert drill.point_angle == pytest.approx(math.radians(118)) and "118 deg" in drill.assumed[0]
    assert setup.figures_of("") is None and setup.figures_of("3") is None
    # two decimals of a seventh of a turn
    pitch = setup_of_text(f"[tools.1]\ndiameter = 6\npitch = {[51.43] * 7}\n").figures_of("1").pitch
    assert sum(pitch) == pytest.approx(math.tau, abs=1e-12) and len(pitch) == 7


PROGRAM = "T1 M6\nG43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X10 A10 F600\nT2 M6\nG43.4 H2\nX20\nM30\n"


def test_tools_without_a_length_are_as_long_as_the_machines_own():
    machine = Machine.load("xyzac-trunnion")
    plain = read_text(PROGRAM, machine, controller="fanuc")
    shapes = read_text(PROGRAM, machine, controller="fanuc", setup=setup_of_text("[tools.1]\nradius = 3\n"))
    assert np.array_equal(plain.tip, shapes.tip) and plain.assumed == shapes.assumed
    assert any("no set-up sheet tells the lengths" in each for each in plain.assumed)
    own = machine.tool_length
    told = setup_of_text("[tools.1]\nlength = 50\n[tools.2]\ndiameter = 6\n")
    mixed = read_text(PROGRAM, machine, controller="fanuc", setup=told)
    assert "tool 2 has no length on the set-up sheet: it is as long as the machine's own" in mixed.assumed
    assert mixed.tool_length[0] == 0.05 and mixed.tool_length[-1] == own


def test_what_a_program_tells_is_filled_in_where_the_sheet_does_not_tell_it():
    told = {"1": ToolFigures("flat", 0.01), "02": ToolFigures("ball", 0.006)}
    stock = WorkpieceFigures(StockFigures(Solid(box=((0.0, 0.0, -0.02), (0.1, 0.1, 0.0)))))
    sheet = setup_of_text("[tools.1]\ndiameter = 8\n[tools.2]\nlength = 90\n")
    found = with_program_figures(sheet, told, stock)
    assert found.figures_of("1").diameter == 0.008 and found.workpiece == stock
    assert found.tools["2"] == Tool(0.09, figures=told["02"])
    assert with_program_figures(replace(sheet, workpiece=stock), {}, WorkpieceFigures()).workpiece == stock


def test_bodies_in_work_offsets_are_left_out_where_the_part_is_clamped_elsewhere():
    box = ((0.0, 0.0, -0.02), (0.1, 0.1, 0.0))
    here, there = Solid(box=box), Solid(box=box, frame="G54")
    kept = WorkpieceFigures(StockFigures(here), there, fixtures=(("a", here), ("b", there))).without_offsets()
    assert kept == WorkpieceFigures(StockFigures(here), fixtures=(("a", here),))


def test_a_sheet_to_fill_in_has_lines_for_tools_and_stock():
    used = Used({}, {}, {"4": None}, False)
    text = setup_sheet("part.nc", used, None, SetUp(), [(0.0, 0.1), (-0.02, 0.05), (-0.003, 0.01)])
    assert "from [0, -20, -3] to [100, 50, 10]" in text
    filled = text.replace("# kind", "kind").replace("# diameter = 0.0", "diameter = 10")
    filled = filled.replace("# teeth = 0", "teeth = 2")
    filled = filled.replace("# flute_length = 0.0", "flute_length = 22").replace("# stick_out = 0.0", "stick_out = 35")
    filled = filled.replace("# [stock]", "[stock]").replace("# box", "box")
    setup = setup_of_text(filled)
    assert setup.figures_of("4") == ToolFigures("flat", 0.01, flute_length=0.022, teeth=2, stick_out=0.035)
    assert setup.workpiece.stock.uncertainty == 1e-3
    assert setup_of_text(setup_sheet("part.nc", used, None, setup)) == setup
    assert "# holder = " in setup_sheet("part.nc", used, None, setup)
    # without any change it says nothing of the cut
    assert setup_of_text(text).workpiece == WorkpieceFigures() and setup_of_text(text).figures_of("4") is None
