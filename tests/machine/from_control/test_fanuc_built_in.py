"""Built-in machines, written as a Fanuc control punches them, are read back."""

from __future__ import annotations

import pytest

from tests.support.fanuc_files import HOLDER, machine_zero, parameters_text, rotary_sides
from tests.support.read_back import assert_comes_back
from toolpace.machine.from_control import read_control
from toolpace.machine.machine import Machine

ALIKE = [name for name in Machine.names() if name != "paper-ab"]
"""All but the machine whose rotary table carries slides."""
INCH = "xyzab-trunnion-inch"
CRANKED = "xyzac-head with a cranked fork"
"""No built-in head has axes that do not meet."""
CASES = [
    *((name, form, True, name == INCH) for name in ALIKE for form in ("30i", "16i")),
    *((name, "30i", False, False) for name in ALIKE if rotary_sides(Machine.load(name))[1]),
    *((CRANKED, form, shifted, False) for form in ("30i", "16i") for shifted in (False, True)),
]


def _machine(name: str) -> Machine:
    if name != CRANKED:
        return Machine.load(name)
    text = Machine.load("xyzac-head").to_toml()
    point = "point = [0, 0, 450]"
    assert text.count(point) == 2
    return Machine.from_toml(text.replace(point, "point = [30, -40, 520]", 1).replace(point, "point = [20, 5, 450]"))


@pytest.mark.parametrize(("name", "form", "shifted", "inch"), CASES)
def test_a_built_in_machine_comes_back(name, form, shifted, inch, tmp_path):
    machine = _machine(name)
    place = tmp_path / "CNC-PARA.TXT"
    place.write_text(parameters_text(machine, form, shifted=shifted, inch=inch))
    draft = read_control([place])
    asked = {each.what.split(" [")[0] for each in draft.stand_ins}
    assert not asked or (form == "16i" and not any("velocity" in each for each in asked))
    assert_comes_back(draft.machine, machine, machine_zero(machine, shifted), stand_ins=asked)


def test_the_holder_counts_from_the_end_of_the_tool(tmp_path):
    """D is beyond the nose by the holder's offset; without it the axis would lie as far from the nose as from D."""
    machine = Machine.load("xyzac-head")
    place = tmp_path / "CNC-PARA.TXT"
    place.write_text(parameters_text(machine, changes={19666: None}))
    point = read_control([place]).machine.file.joints["A"].point
    assert point == pytest.approx((0.0, 0.0, 0.3 - HOLDER * 1e-3))
