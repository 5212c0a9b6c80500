"""Reading takes time in proportion to what is read, however odd it is."""

from __future__ import annotations

import itertools
import re

import pytest

from tests.support.growth import order_of_growth
from tests.support.table_table import MACHINE
from toolpace.common import units
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading import languages, read_text, table
from toolpace.programs.reading.cldata import words as cl_words
from toolpace.programs.reading.feeds import FeedChange
from toolpace.programs.reading.gcode.program import words as gcode_words

HEADS = [
    "", "x [mm],y [mm],z [mm]\n", "x [mm],y [mm],z [mm],feed [mm/min]\n0,0,0,1\n", "x[", '"', "GOTO/", "FEDRAT/",
    "DELAY/", "SPINDL/", "CIRCLE/", "UNITS/", "MSYS/", "TOOL ", "A)", "PARTNO", "FEDRAT/100\nGOTO/0,0,0\nGOTO/",
    "G0 X", "G1 X1 (", "G0 X0 Y0 Z0\nG1 X1 F", "O", ":", "(", "1",
]  # fmt: skip
PIECES = [
    " ", "\t", "\n", " \n", "\f", "\u00a0", "1", ",", ".", "-", "(", ")", "()", "[", '"', "x", "x ", "x(", "1 ", "1,",
    "E1", "1D", "G1", "N1 ", "/ ", ";", "$", "$\n", "$$\n", "A1)", "_", "%", "PATH ", "RAPID ", "GOTO ",
]  # fmt: skip
TAILS = ["", "!", " y z", "\n!"]
LONG, LONGER = 10_000, 40_000
SECONDS = 1.0
"""Of CPU time: four times that of the slowest line here under load; what is quadratic takes ten times as long."""


def readings(text):
    for name in (None, "gcode", "apt", "csv"):
        try:
            read_text(text, MACHINE, name)
        except ToolpaceError as error:
            assert len(str(error)) < 1000


def quantities(text):
    for parse in (units.parse_length, units.parse_time, units.parse_percent, FeedChange.parse):
        try:
            parse(text)
        except ToolpaceError as error:
            assert len(str(error)) < 1000


NASTY = {
    "header of a table": (readings, lambda n: "x" + " " * n + "!\n"),
    "header of a table, blanks first": (readings, lambda n: " " * n + "!\n"),
    "unit of a column": (readings, lambda n: "x [" + " " * n + "mm\n"),
    "blank lines": (readings, lambda n: (" " * (n // 150) + "\n") * 150 + "!"),
    "digits": (readings, lambda n: "GOTO/" + "1" * n + "!\n"),
    "digits of a feed": (readings, lambda n: "FEDRAT/" + "1" * n + "x\n"),
    "comments": (readings, lambda n: "(a" * n + "\n"),
    "quantity, blanks": (quantities, lambda n: "1" + " " * n + "x y"),
    "quantity, digits": (quantities, lambda n: "1" * n + " x y"),
}


@pytest.mark.parametrize("case", NASTY)
def test_long_lines_cost_what_they_are_long(case):
    """An order of growth that nothing quadratic can have, between 10^5 and 4 * 10^5 characters."""
    read, text = NASTY[case]
    assert order_of_growth(read, text(100_000), text(400_000), 4.0) < 1.6


@pytest.mark.parametrize(
    "part", [pytest.param(part, marks=pytest.mark.thorough if part else pytest.mark.sweep) for part in range(13)]
)
def test_whatever_is_repeated_costs_what_it_is_long(part):
    """Every head, piece and tail together, a thirteenth of them at a time."""
    import time

    for head, piece, tail in itertools.islice(itertools.product(HEADS, PIECES, TAILS), part, None, 13):
        for read in (readings, quantities):
            text = head + piece * (LONGER // len(piece)) + tail
            began = time.process_time()
            read(text)
            assert time.process_time() - began < SECONDS, (head, piece, tail)


def test_no_expression_gives_back_blanks_or_digits_next_to_others():
    """A repetition of blanks or digits that can be given back is possessive, or stands where it fails at once."""
    held = {
        "table": [table._COLUMN], "units": [units._QUANTITY], "cldata": [cl_words.NUMBER],
        "languages": [languages._CLDATA, languages._TABLE, languages._GCODE, languages._CONVERSATIONAL],
        "gcode": [gcode_words._BLOCK],
    }  # fmt: skip
    loose = re.compile(r"(?:\\s|\[0-9\]|\[\^\\S\\n\]|\[A-Za-z\])[*+](?!\+)")
    for room, expressions in held.items():
        for expression in expressions:
            assert not loose.search(expression.pattern), (room, expression.pattern)


@pytest.mark.sweep
def test_a_million_characters_in_a_line():
    for text in (" " * 10**6, "1" * 10**6, "," * 10**6, "(" * 10**6, '"' * 10**6, "\n" * 10**6 + "!", "x " * 500_000):
        readings(text)
        readings("GOTO/" + text)
        quantities(text)
