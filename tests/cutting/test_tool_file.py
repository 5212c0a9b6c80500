"""TOOL.toml: the example of the documentation, each way to say stiffness, and one clear error for all that is wrong."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import toolpace as tp
from tests.support.bending import TOOL_FILE
from toolpace.common.errors import UsageError
from toolpace.cutting.tool_file import FILE, tool_of_bytes

PAGE = Path(__file__).parents[2] / "docs" / "design" / "bending.md"


def read(text):
    return tool_of_bytes(text.encode(), "my.toml")


def test_the_example_of_the_documentation_is_a_tool():
    example, operations = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    tool = read(example)
    assert tool.cut.cutter.diameter == pytest.approx(4e-3) and tool.data == example.encode()
    assert set(read(example + operations).operations) == {"SEMIFINISH", "PROBE"}
    for other in ("stiffness", "compliance"):
        lines = [line for line in example.splitlines() if "youngs_modulus =" not in line and "bends alike" not in line]
        tried = read("\n".join(lines).replace(f"# {other}", other))
        np.testing.assert_allclose(tried.compliance, tool.compliance, rtol=0.08)


def test_figures_come_with_their_units():
    tool = read(TOOL_FILE)
    assert tool.cut == tp.Cut(
        tp.Cutter(4e-3, 2, np.radians(30.0)),
        tp.Coefficients(800e6, 300e6, 0.0, 15e3, 12e3),
        tp.Engagement("down", 8e-3, 0.15e-3),
        300.0,
    )
    np.testing.assert_array_equal(tool.compliance, tp.Bending.cantilever(4e-3, 40e-3, 580e9).compliance)
    assert tool.blend == 4e-3 and tool.force == "mean" and tool.only == () and tool.source == "my.toml"
    assert repr(tool) == "<CuttingTool 4 mm, 2 teeth, down>"


def test_a_material_stands_in_for_the_coefficients_that_the_file_leaves_out():
    text = TOOL_FILE.replace('Ktc = "800MPa"', 'material = "Al7075-T6"\ncutter = "HSS"')
    found, material = read(text).cut.coefficients, tp.Material.load("Al7075-T6", "HSS").coefficients
    assert found.tangential == material.tangential and found.axial_edge == material.axial_edge
    assert found.radial == 300e6 and found.tangential_edge == 15e3


def test_runout_is_what_a_dial_shows():
    assert read(TOOL_FILE.replace("teeth = 2", 'teeth = 2\nrunout = "6um"')).cut.cutter.runout == 3e-6


def test_stiffness_and_compliance_in_place_of_a_beam():
    springs = read(TOOL_FILE.replace('youngs_modulus = "580GPa"', 'stiffness = ["2N/um", "4N/um", "100N/um"]'))
    np.testing.assert_allclose(springs.compliance, np.diag([5e-7, 2.5e-7, 1e-8]))
    matrix = read(
        TOOL_FILE.replace('youngs_modulus = "580GPa"', "compliance = [[0.5, 0.1, 0], [0.1, 0.25, 0], [0, 0, 0.01]]")
    )
    np.testing.assert_allclose(matrix.compliance, 1e-6 * np.array([[0.5, 0.1, 0], [0.1, 0.25, 0], [0, 0, 0.01]]))


def test_operations_have_cuts_of_their_own():
    tool = read(
        TOOL_FILE
        + '[engagement.operations.ROUGH]\nradial_depth = "1mm"\n[engagement.operations.PROBE]\nmilling="none"\n'
    )
    assert tool.operations["PROBE"] is None
    assert tool.operations["ROUGH"].engagement == tp.Engagement("down", 8e-3, 1e-3)
    assert tool.cut.engagement.radial_depth == 0.15e-3


@pytest.mark.parametrize(
    ("was", "becomes", "says"),
    [
        ("teeth = 2", "teth = 2", r"\[tool\] has the unknown key 'teth'; did you mean 'teeth'"),
        ("teeth = 2", "", r"\[tool\] teeth = None: write how many"),
        ("teeth = 2", "teeth = true", "teeth = True"),
        ("teeth = 2", "teeth = 2.5", "teeth = 2.5"),
        ('diameter = "4mm"', "", r'\[tool\] diameter is missing; write it like diameter = "4mm"'),
        ('diameter = "4mm"', "diameter = 4", r"\[tool\] diameter = 4 has no unit; write it in quotes"),
        ('diameter = "4mm"', 'diameter = "4"', "length '4' has no unit"),
        ('diameter = "4mm"', 'diameter = "0mm"', "is nothing"),
        ('diameter = "4mm"', 'diameter = "4m"', "more than 1 m: check its unit"),
        ('diameter = "4mm"', 'diameter = "-4mm"', "must be zero or more"),
        ('stick_out = "40mm"', "", "stick_out is missing: youngs_modulus needs it"),
        ('stick_out = "40mm"', 'stick_out = "4mm"', "axial_depth = '8mm' is more than the stick_out of 4 mm"),
        ("[bending]", "[bendng]", r"the file has the unknown key 'bendng'; did you mean 'bending'"),
        ('youngs_modulus = "580GPa"', "", r"\[bending\] says nothing of stiffness; write one of"),
        ('youngs_modulus = "580GPa"', 'youngs_modulus = "580"', "has no unit"),
        ('youngs_modulus = "580GPa"', 'youngs_modulus = "0GPa"', "youngs_modulus is 0"),
        ("[cutting]", 'stiffness = ["1N/um", "1N/um", "1N/um"]\n[cutting]', "has youngs_modulus and stiffness"),
        ('youngs_modulus = "580GPa"', 'stiffness = ["1N/um", "1N/um"]', "is not a list of three"),
        ('youngs_modulus = "580GPa"', 'stiffness = ["1N/um", "1", "1N/um"]', "stiffness y: stiffness '1' has no unit"),
        ('youngs_modulus = "580GPa"', "compliance = [[1, 0, 0], [0, 1], [0, 0, 1]]", "row"),
        ('youngs_modulus = "580GPa"', "compliance = [[1, 0, 0], [0, 'a', 0], [0, 0, 1]]", "no finite number"),
        ('youngs_modulus = "580GPa"', "compliance = [[1, 0, 0], [1, 1, 0], [0, 0, 1]]", "not symmetric"),
        (
            'youngs_modulus = "580GPa"',
            'stiffness = ["1N/um", "1N/um", "1N/um"]\ndiameter = "3mm"',
            "remove one of both",
        ),
        ('spindle_speed = "18000rpm"', 'spindle_speed = "18000"', "like 18000rpm"),
        ('spindle_speed = "18000rpm"', 'spindle_speed = "0rpm"', "above zero"),
        ('Ktc = "800MPa"', "", "Ktc is missing"),
        ('Ktc = "800MPa"', 'Ktc = "800N/mm"', "'N/mm' is not a unit of pressure"),
        ('Ktc = "800MPa"', 'Ktc = "800MPa"\nforce = "median"', "force = 'median' is not known"),
        ('milling = "down"', 'milling = "climb"', "milling = 'climb' is not known"),
        ('milling = "down"', "", r"\[engagement\] milling is missing; write one of up, down, slot"),
        ('milling = "down"', 'milling = "none"', "nothing cuts"),
        ('radial_depth = "0.15mm"', 'radial_depth = "5mm"', "more than the diameter of 4 mm"),
        ('radial_depth = "0.15mm"', "", "radial_depth is missing"),
        ('Ktc = "800MPa"', "material = 3", "material and cutter are words"),
        ('Ktc = "800MPa"', 'cutter = "HSS"', "material and cutter are words"),
        ('Ktc = "800MPa"', 'material = "Al7057-T6"', r"\[cutting\] material: material 'Al7057-T6' is not known"),
        ('Ktc = "800MPa"', 'material = "own.toml"', "is a file; write its coefficients here"),
        ("[engagement]", "[engagement]\noperations = 3", "operations is not a table"),
        ("[engagement]", "[engagement]\noperations = {A = 3}", r"operations.A\] = 3 is not a table"),
        ("teeth = 2", 'teeth = 2\nrunout = "3mm"', "runout of 1500 mm|runout of 1.5 mm"),
        ("teeth = 2", "teeth = 2\nonly = 3", "only = 3: write the tools"),
        ("helix", "helix = ", "not a TOML file"),
        ("[tool]", "", "unknown key 'diameter'"),
        ("teeth = 2", "teeth = " + "[" * 2000, "lie too deep|not a TOML file"),
    ],
)
def test_what_is_wrong_is_one_error_that_names_file_key_and_cure(was, becomes, says):
    assert was in TOOL_FILE
    with pytest.raises(UsageError, match=says) as caught:
        read(TOOL_FILE.replace(was, becomes, 1))
    text = str(caught.value)
    assert text.startswith("my.toml: ") and "\n" not in text and len(text) <= 520


def test_what_is_no_file_of_text_is_one_error(tmp_path):
    with pytest.raises(UsageError, match="cannot be read"):
        tp.load_tool(tmp_path / "none.toml")
    with pytest.raises(UsageError, match="cannot be read"):
        tp.load_tool(tmp_path)
    with pytest.raises(UsageError, match=r"no such name|cannot be read"):
        tp.load_tool("a\0b")
    with pytest.raises(UsageError, match="save it as UTF-8"):
        tool_of_bytes(b"\xff\xfe", "my.toml")
    with pytest.raises(UsageError, match="this is no tool file"):
        tool_of_bytes(b"#" * (FILE.longest + 1), "my.toml")
