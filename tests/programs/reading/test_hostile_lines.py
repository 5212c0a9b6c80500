"""Lines that no program has, and that a reader meets all the same: they end in one clear error, and soon."""

from __future__ import annotations

import time

import pytest

from toolpace.common.errors import ProgramError
from toolpace.programs.reading import Source, read_text
from toolpace.programs.reading.languages import dialect_of

HEIDENHAIN = "L X+0 Y+0 Z+0 FMAX\n{}\nL X+1 F100\n"
SINUMERIK = "G90 G0 X0 Y0 Z0\n{}\nG1 X1 F100\n"
DIGITS = "9" * 4500
"""More than Python turns into a whole number."""
BLANKS = " " * 4000
SECONDS = 1.0
"""Of CPU time; what takes the square of a length, or more, takes far longer."""

WRONG = {
    "function": ("heidenhain", HEIDENHAIN, f"FN {DIGITS}: Q1 = +5", "at most 4096 are read"),
    "cycle": ("heidenhain", HEIDENHAIN, f"CYCL DEF {DIGITS}.1 X", "at most 4096 are read"),
    "line of a cycle": ("heidenhain", HEIDENHAIN, f"CYCL DEF 7.{DIGITS} X", "at most 4096 are read"),
    "parameter of a cycle": ("heidenhain", HEIDENHAIN, f"CYCL DEF 200 Q{DIGITS}=1", "at most 4096 are read"),
    "condition": ("heidenhain", HEIDENHAIN, f"FN 9: IF{BLANKS}NE", "is written IF"),
    "conditions": ("heidenhain", HEIDENHAIN, f"FN 9: IF 1 {'NE GOTO ' * 450}", "is written IF"),
    "dwell": ("heidenhain", HEIDENHAIN, f"CYCL DEF 9.1 DWELL{BLANKS}x", "has one figure"),
    "quoted semicolons": ("heidenhain", HEIDENHAIN, 'QS1 = "' + ";" * 1_000_000, "at most 4096 are read"),
    "loop that cannot be read": ("sinumerik", SINUMERIK, "FOR R1=1 TO 1e30\nENDFOR", "1e30"),
    "choice that cannot be read": ("sinumerik", SINUMERIK, "IF R1==\nELSE\nENDIF", "IF R1=="),
    "form feed before a structure": ("sinumerik", SINUMERIK, "\fIF 0", "IF is never closed"),
    "M function": ("sinumerik", SINUMERIK, f"M{'9' * 400}", "are whole numbers"),
}
RIGHT = {
    "blanks before a word": ("sinumerik", SINUMERIK, f"ENDIFX_1: R2=1\nIF 0\n{BLANKS}R1=1\nENDIF"),
    "blanks before a structure": ("sinumerik", SINUMERIK, f"{BLANKS}IF 1\n/ N10{BLANKS}LABEL_1:{BLANKS}R1=1\nENDIF"),
    "text with a semicolon": ("heidenhain", HEIDENHAIN, 'QS1 = "A;B" ; "C'),
    "point behind a name": ("heidenhain", HEIDENHAIN, "CYCL DEF 11.1 SCL.5"),
}


def spent(controller: str, text: str) -> float:
    began = time.process_time()
    path = read_text(text, None, "gcode", controller=controller)
    assert len(path) == 2
    return time.process_time() - began


@pytest.mark.parametrize("case", WRONG)
def test_wrong_lines_end_in_one_error_that_names_them(case):
    controller, around, line, words = WRONG[case]
    began = time.process_time()
    with pytest.raises(ProgramError) as caught:
        read_text(around.format(line), None, "gcode", controller=controller)
    assert time.process_time() - began < SECONDS
    assert words in str(caught.value) and str(caught.value).startswith("program:2: ") and len(str(caught.value)) < 300


@pytest.mark.parametrize("case", RIGHT)
def test_odd_lines_are_read_in_time(case):
    controller, around, line = RIGHT[case]
    assert spent(controller, around.format(line)) < SECONDS


def test_a_scale_that_begins_with_its_point():
    text = HEIDENHAIN.format("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL.5")
    assert read_text(text, None, "gcode", controller="heidenhain").tip[-1, 0] == pytest.approx(0.0005)


@pytest.mark.parametrize("cell", ["1_0", "\u0663", "", "0x1", "1 2", "--1"])
def test_the_cell_of_a_table_that_is_no_number_is_named(cell):
    with pytest.raises(ProgramError, match=f"^program:3: '{cell}' is no number") as caught:
        read_text(f"x [mm],y [mm],z [mm]\n0,0,0\n1,{cell},3\n", None, "csv")
    assert caught.value.line == 3


def test_a_word_without_end_is_left_out_of_its_message():
    with pytest.raises(ProgramError, match=r"^program:1: word A9999.* \.\.\. .*9999") as caught:
        read_text(f"G7 A{'9' * 4400}=1\nM30\n", None, "gcode", controller="millplus")
    assert len(str(caught.value)) < 1200


def test_the_line_by_which_a_program_is_told_is_shown_as_one_line():
    """Found by fuzzing: a separator of lines within what a pattern takes for a heading."""
    found = dialect_of(Source.from_text("x\u2028(n)\n1\n"))
    assert found.dialect == "csv" and found.reason == r"it has lines like 'x\u2028(n)'"
