"""Shapes of tools from names and comments, by rules of a controller's file."""

from __future__ import annotations

import math

import pytest

from toolpace.common.errors import UsageError
from toolpace.programs.reading import Controller, read_text
from toolpace.programs.tool_figures import ToolFigures

BY_NAME = r"""
name = "spinner"
like = "sinumerik"
[[tools]]
pattern = 'ENTFRAESER_D(?P<diameter>[0-9.]+)(?:_N)?_(?P<point_angle>[0-9]+)GRAD'
kind = "chamfer"
[[tools]]
pattern = '(?P<kind>SCHAFT|BOHRER|PLAN)_D(?P<diameter>[0-9.]+)(?:_N)?(?:_AP(?P<flute_length>[0-9.]+))?'
kinds = { SCHAFT = "flat", BOHRER = "drill", PLAN = "face" }
"""


@pytest.mark.parametrize(
    "name, figures",
    [
        # the names of tools in "Production data set for five-axis CNC milling with multiple changeovers" (CC BY 4.0)
        ("SCHAFT_D12_N_AP30", ToolFigures("flat", 0.012, flute_length=0.03)),
        ("SCHAFT_D8_N_AP20", ToolFigures("flat", 0.008, flute_length=0.02)),
        ("ENTFRAESER_D8_90GRAD", ToolFigures("chamfer", 0.008, point_angle=0.5 * math.pi)),
        ("ENTFRAESER_D8_N_90GRAD", ToolFigures("chamfer", 0.008, point_angle=0.5 * math.pi)),
        ("BOHRER_D3.3_VHM", ToolFigures("drill", 0.0033)),
        ("PLAN_D50_N_AP4", ToolFigures("face", 0.05, flute_length=0.004)),
        ("TASTER_1", None),
        ("SCHAFT_D900", None),
    ],
)
def test_names_tell_shapes_by_a_rule(name, figures):
    program = f'T="{name}"\nM6\nG0 X0 Y0 Z5\nG1 Z-1 F200\nM30\n'
    path = read_text(program, controller=Controller.from_toml(BY_NAME))
    (operation,) = path.operations
    found = operation.figures
    if figures is None:
        assert found is None
        return
    for key in ("kind", "teeth"):
        assert getattr(found, key) == getattr(figures, key)
    for key in ("diameter", "flute_length", "point_angle"):
        assert getattr(found, key) == (getattr(figures, key) and pytest.approx(getattr(figures, key)))
    assert name in found.source
    assert read_text(program, controller="sinumerik").operations[0].figures is None


BY_COMMENT = r"""
name = "shop"
like = "haas"
[[tools]]
pattern = 'T(?P<tool>[0-9]+) +D=(?P<diameter>[0-9.,]+) +CR=(?P<corner_radius>[0-9.,]+).* - (?P<kind>[a-z ]+)[)]'
kinds = { "flat end mill" = "flat", "face mill" = "face" }
UNIT
"""
HEAD = "%\nO1001 (PART)\n(T1 D=12. CR=0. - ZMIN=-5. - flat end mill)\n(T02 D=6. CR=3. - ZMIN=-9. - ball end mill)\n"
HEAD += "(T3 D=6. CR=4. - ZMIN=-9. - bullnose end mill)\nG90 G54 G21\n"
BODY = "".join(f"T{k} M6\nS5000 M3\nG0 X0 Y0 Z{k}\nG1 Z-1 F200\nX10\nG0 Z50\n" for k in (2, 1, 3))


@pytest.mark.parametrize("unit, metres", [("", 1e-3), ('unit = "in"', 0.0254)])
def test_comments_tell_shapes_by_a_rule(unit, metres):
    path = read_text(HEAD + BODY + "M30\n%\n", controller=Controller.from_toml(BY_COMMENT.replace("UNIT", unit)))
    ball, flat, none = (operation.figures for operation in path.operations)
    assert (ball.kind, ball.diameter, ball.source) == ("ball", pytest.approx(6 * metres), "program:4: comment")
    assert (flat.kind, flat.diameter) == ("flat", pytest.approx(12 * metres))
    assert none is None  # a corner radius of more than half of the diameter
    assert all(each.figures is None for each in read_text(HEAD + BODY + "M30\n%\n", controller="haas").operations)


@pytest.mark.parametrize(
    "rule, said",
    [
        ("pattern = 'D(?P<durchmesser>[0-9]+)'", "group 'durchmesser'"),
        ("pattern = 'D(?P<diametre>[0-9]+)'", "did you mean 'diameter'"),
        ("pattern = 'D([0-9]+)'", "no group 'diameter'"),
        ("pattern = 'D(?P<diameter>[0-9]+'", "controller file: "),
        ("pattern = 'D(?P<diameter>[0-9]+)'\nkind = 'torus'", "kind 'torus'"),
        ("pattern = 'D(?P<diameter>[0-9]+)'\nunit = 'mil'", "unit 'mil'"),
        ("pattern = 'D(?P<diameter>[0-9]+)'\nkindes = 'x'", "kindes"),
    ],
)
def test_a_rule_that_makes_no_sense_is_one_line(rule, said):
    with pytest.raises(UsageError) as caught:
        Controller.from_toml(f'name = "a"\nlike = "haas"\n[[tools]]\n{rule}\n')
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_rules_are_printed_and_handed_on():
    shop = Controller.from_toml(BY_NAME)
    again = Controller.from_toml(shop.to_toml())
    assert again.tools == shop.tools and len(again.tools) == 2
