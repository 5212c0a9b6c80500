"""Structure of blocks: TNC 640 Klartext manual, "Fundamentals: programming, opening and entering programs"."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.heidenhain import CONTROLLER, findings, last, read, reader, tips
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.reader import HeidenhainReader
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source


def test_block_numbers_may_be_there_padded_or_missing():
    """ "Block numbers" are counted by the control; posts pad them, and leave them out of continued lines."""
    numbered = last("3 L X+1 F100\n0040 L Y+2\n 50 L Z+3")
    assert numbered == last("L X+1 F100\nL Y+2\nL Z+3") == (1, 2, 3)


def test_a_set_up_sheet_before_the_program_and_n_before_the_numbers():
    """Simulators for training write their set-up behind open brackets, and number blocks as in DIN 66025."""
    sheet = "( Set-up\n\n(   Offset G54: X1 Y2\n"
    source = Source.from_text(
        sheet + "BEGIN PGM 01 MM\nN1 TOOL CALL 1 Z S9\nN2 L X0 Y2 F100\nN3 L X1\nN4 END PGM 01 MM\n"
    )
    found = Findings()
    path = HeidenhainReader(source, None, CONTROLLER, ReadOptions(CONTROLLER), found).executed().toolpath()
    assert path.tip[-1, 0] == 0.001 and found.skipped["( before BEGIN PGM"] == 1
    with pytest.raises(ProgramError, match="no statement of Klartext"):
        read("( within the program\nL X+1 F100")


@pytest.mark.parametrize("word", ["X+1.5", "X1.5", "X+1,5", "X 1.5", "X+01.50", "X +1.5"])
def test_numbers_have_point_or_comma_and_a_sign_if_they_like(word):
    assert last(f"L {word} F100") == (1.5, 0, 0)


def test_numbers_without_a_digit_before_or_behind_the_point():
    assert last("L X+.6 Y90. Z-,5 F100") == (0.6, 90, -0.5)


def test_comments_and_headings_move_nothing_and_a_heading_names_the_operation():
    """ "Adding comments" and "Structuring programs"."""
    path = read("* - ROUGHING\nL X+1 F100 ; L X+9\n; L X+8\n* - FINISHING\nL X+2")
    assert [operation.name for operation in path.operations] == ["", "ROUGHING", "FINISHING"]
    assert path.tip[-1, 0] == 0.002


def test_a_semicolon_in_quotation_marks_is_text():
    assert last('QS1 = "A;B"\nL X+1 F100') == (1, 0, 0)


def test_a_comment_that_names_the_tool_names_the_operation():
    """NX's posts write the tool's name as a comment."""
    path = read("; TOOL NAME BALL_D6\nL X+1 F100")
    assert path.operations[-1].name == "BALL_D6"


def test_the_slash_skips_a_block_unless_told_otherwise():
    """ "Skipping blocks": the slash stands before the block, behind its number."""
    text = "3 L X+1 F100\n4 / L X+5"
    assert last(text) == (1, 0, 0)
    assert last(text, block_delete=False) == (5, 0, 0)
    hidden = "3 L X+1 F100\n/4 L X+5"  # hyperMILL's posts put it before the number
    assert last(hidden) == (1, 0, 0) and last(hidden, block_delete=False) == (5, 0, 0)


def test_a_block_that_the_control_marked_is_refused_as_such():
    with pytest.raises(ProgramError, match="ERROR is not read: the control stops at a block that it has marked so"):
        read("L X+1 F100\n4 ERROR = 13 TOOL CALL\nL X+2")


def test_a_block_goes_on_behind_the_tilde_and_where_a_post_leaves_it_out():
    with_mark = "7 CYCL DEF 200 DRILLING ~\n Q200=+2 ;CLEARANCE ~\n Q201=-5 ~\n Q206=100 ~\n Q202=5 ~\n Q203=0"
    without = with_mark.replace("~", "").replace(" Q20", "   Q20")
    hole = "\n8 L X+3 FMAX M99"
    assert np.array_equal(tips(with_mark + hole), tips(without + hole))
    assert tips(with_mark + hole)[:, 2].min() == pytest.approx(-5)


def test_a_remark_goes_on_behind_the_tilde_in_lines_without_numbers():
    """So controls write remarks that are longer than a line; a row of tildes is no such mark."""
    remark = (
        "7 ;This program is free software: you can redistribute it~\n under the terms of the GNU Licence~\n or not.\n"
    )
    assert last(remark + "8 L X+3 F100") == (3, 0, 0)
    assert last("7 ;~~~~~~~~\nL X+3 F100\n8 ;A remark ~\n9 L Y+2") == (3, 2, 0)
    assert last(";a remark of a file without numbers ~\nL X+3 F100") == (3, 0, 0)


def test_a_formula_behind_a_cycle_is_a_block_of_its_own():
    cycle = "7 CYCL DEF 200 DRILLING ~\n Q200=+2 ~\n Q201=-5 ~\n Q206=100 ~\n Q202=5 ~\n Q203=0\n"
    assert last(cycle + "8 Q204 = 7\n9 L X+Q204 F100") == (7, 0, 0)
    # a cycle in lines has no parameters of that kind, also where the blocks have no numbers
    assert last("CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 2\nQ204 = 7\nL X+Q204 F100") == (7, 0, 0)


def test_empty_words_of_old_posts_say_nothing():
    assert last("L X+1 R F100 M") == (1, 0, 0)


def test_a_blank_in_fmax():
    assert read("L X+1 F MAX").rapid.all()


def test_a_program_in_inches():
    """BEGIN PGM .. INCH: lengths in inches, F in 0.1 inch a minute (manual: "Feed rate F", units)."""
    path = read("L X+1 F100", unit="INCH")
    assert path.tip[-1, 0] == pytest.approx(0.0254, abs=1e-15)
    assert path.feed[-1] == pytest.approx(10 * 0.0254 / 60)


def test_nx_spells_inches_in_and_means_inches_a_minute():
    path = read("L X+1 F78.7", unit="IN")
    assert path.feed[-1] == pytest.approx(78.7 * 0.0254 / 60)
    assert any("F is in inches a minute" in said for said in path.assumed)


def test_the_unit_of_feed_is_an_option():
    import msgspec

    other = msgspec.structs.replace(CONTROLLER, options={**CONTROLLER.options, "inch_feed": "inch"})
    assert read("L X+1 F10", unit="INCH", controller=other).feed[-1] == pytest.approx(10 * 0.0254 / 60)


def test_what_is_unknown_is_refused_all_of_it_in_one_run():
    with pytest.raises(ProgramError) as error:
        read("FL X+1\nSPL X5\nL X+1 F100\nSPL X6\nHOP X+3")
    for part in ("3 kinds", "FL (first line 4)", "SPL (first line 5, 2 times)", "HOP (first line 8)"):
        assert part in str(error.value)


def test_refused_words_are_passed_over_where_that_is_wanted():
    found = findings("SPL X5\nL X+1 F100")
    assert [refusal.word for refusal in found.refusals] == ["SPL"]
    assert "skipped SPL (first line 4, 1 time)" in found.assumptions


def test_a_coordinate_that_is_no_number_names_line_and_word():
    with pytest.raises(ProgramError, match=r"test\.h:4: X has no value.*'L X\+'"):
        read("L X+")


def test_a_word_twice_in_a_block():
    with pytest.raises(ProgramError, match="X stands twice"):
        read("L X+1 X+2 F100")


def test_a_program_that_is_cut_off():
    source = Source.from_text("BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\nL X+1 F1", "cut.h")
    with pytest.raises(ProgramError, match="looks cut off"):
        HeidenhainReader(source, None, CONTROLLER, ReadOptions(), Findings()).executed().toolpath()


def test_every_sign_of_the_file_tells_a_line_of_klartext():
    import re

    lines = ["0 BEGIN PGM A MM", "5 TOOL CALL 3 Z S100", "6 L X+1 R0", "7 L Z+2 FMAX", "8 CYCL DEF 7.0 DATUM SHIFT"]
    for sign, line in zip(CONTROLLER.signs, lines, strict=True):
        assert re.search(sign.pattern, line)
        for other in ("N10 G1 X1. F100", "GOTO/1,2,3", "MCALL CYCLE81(5,0,1,-3)", "G0 G54 X0 Z5."):
            assert not re.search(sign.pattern, other)


def test_operations_and_tools():
    """TOOL CALL is a tool change: the machine stops, and an operation begins; again the same tool is a new speed."""
    path = read('L X+1 F100\nTOOL CALL 2 Z S500\nL X+2\nTOOL CALL 2 Z S900\nL X+3\nTOOL CALL "Mill" Z\nL X+4')
    assert [operation.tool for operation in path.operations] == ["1", "2", "MILL"]
    assert list(path.stop) == [True, True, False, True, True]


def test_reader_counts_blocks():
    made = reader("L X+1 F100")
    assert made.executed().toolpath().blocks == 5
