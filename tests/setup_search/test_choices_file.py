"""Files of choices: what they say, and one clear line for what they must not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.setup_search.choices import Choice, Choices, choices_of_text, load_choices

FILE = """
[choose]
tilt = [0, 30, 60]
turn = {from = -90, to = 90}
swing = 15
x = {from = -40, to = 40}
y = 0
tool_length = [80, 120]
solution = ["+", "free"]

[[forbidden]]
name = "tool changer"
X = [200, inf]
A = [-100, -20]
"""


def test_a_file_says_all():
    found = choices_of_text(FILE)
    assert found.tilt.values == pytest.approx(np.radians([0, 30, 60]))
    assert (found.turn.low, found.turn.high) == pytest.approx((-math.pi / 2, math.pi / 2)) and not found.turn.is_listed
    assert found.swing.values == pytest.approx([math.radians(15.0)]) and not found.swing.is_free
    assert found.tool_length is not None and found.tool_length.values == pytest.approx([0.08, 0.12])
    assert found.side.values == (0.0, 1.0)
    assert found.direction == ("turn", "tilt", "tool_length", "side") and found.position == ("x", "z")
    (zone,) = found.forbidden
    assert zone.name == "tool changer" and zone.bounds["X"] == (0.2, math.inf)
    assert zone.bounds["A"] == pytest.approx(np.radians([-100, -20]))
    assert found.box() == pytest.approx(np.array([[-0.04, 0.04], [0.0, 0.0], [0.0, 0.1]]))


def test_an_empty_file_leaves_the_usual_choices():
    assert choices_of_text("") == Choices()


def test_units_are_those_of_the_file():
    found = choices_of_text('units = {length = "in", angle = "rad"}\nchoose = {x = {from = -1, to = 2}, tilt = 0.5}\n')
    assert (found.x.low, found.x.high) == pytest.approx((-0.0254, 0.0508)) and found.tilt.values == (0.5,)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[choos]\n", r"unknown key 'choos'; did you mean 'choose'"),
        ("[choose]\ntlit = 3\n", r"\[choose\] has the unknown key 'tlit'; did you mean 'tilt'"),
        ("[choose]\ntilt = 'much'\n", r"\[choose\] tilt = 'much' is not a number; write it in deg, like 12.5"),
        ("[choose]\ntilt = []\n", r"lists 0 values; write 1 to 100"),
        ("[choose]\ntilt = {from = 30, to = 0}\n", r"runs from 30 to 0; write the lower one first"),
        ("[choose]\ntilt = {from = 30}\n", r"is no range; write \{from = 0, to = 45\}"),
        ("[choose]\ntilt = {from = 3, to = 4, by = 1}\n", r"unknown key 'by'"),
        ("[choose]\nx = [1, 2]\n", r"\[choose\] x = \[1, 2\] is a list; a place is one value or a range"),
        ("[choose]\nx = 1e9\n", r"is more than 100000 mm: check its unit"),
        ("[choose]\ntool_length = -5\n", r"below zero; write it from the spindle nose"),
        ("[choose]\ntilt = nan\n", r"nan is not a number"),
        ("[choose]\nsolution = 'left'\n", r"solution = 'left' is not known; write 'both', 'free'"),
        ("[units]\nlength = 'ft'\n", r"\[units\] length = 'ft' is not known"),
        ("[[forbidden]]\nname = 'a'\n", r"\[\[forbidden\]\] a bounds no joint"),
        ("[[forbidden]]\nX = [3, 1]\n", r"holds nothing; write the lower position first"),
        ("[[forbidden]]\nX = 3\n", r"is not two positions"),
        ("forbidden = 3\n", r"write each zone under \[\[forbidden\]\]"),
        ("[choose\n", r"not a TOML file"),
    ],
)
def test_what_makes_no_sense_is_one_line(text, said):
    with pytest.raises(UsageError, match=said) as error:
        choices_of_text(text, "fixtures.toml")
    assert str(error.value).startswith("fixtures.toml") and "\n" not in str(error.value)


def test_a_zone_of_another_machine_is_refused():
    choices = choices_of_text("[[forbidden]]\nB = [0, 1]\n", "fixtures.toml")
    with pytest.raises(UsageError, match="forbidden zone 1: machine xyzac-trunnion has no joint B; known: X, Y"):
        choices.checked(Machine.load("xyzac-trunnion"))


def test_a_missing_file_is_named():
    with pytest.raises(UsageError, match=r"choices nowhere\.toml: cannot be read"):
        load_choices("nowhere.toml")


def test_shares_and_values_go_both_ways():
    listed, ranged = Choice((3.0, 1.0, 2.0)), Choice.between(-1.0, 3.0)
    for choice in (listed, ranged):
        for share in np.linspace(0.0, 1.0, 13):
            value = choice.at(float(share))
            assert choice.at(choice.share_of(value)) == pytest.approx(value)
    assert Choice.between(2.0, 2.0).values == (2.0,)
