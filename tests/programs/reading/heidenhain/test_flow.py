"""Labels, repeats, jumps, other programs: TNC 640 Klartext manual, "Subprograms and program section repeats"."""

from __future__ import annotations

import pytest

from tests.support.heidenhain import CONTROLLER, findings, last, read, reader, tips
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.findings import Findings
from toolpace.programs.reading.heidenhain.reader import HeidenhainReader
from toolpace.programs.reading.options import ReadOptions
from toolpace.programs.reading.source import Source


def test_a_subprogram_behind_the_end_runs_where_it_is_called():
    text = "L X+1 F100\nCALL LBL 5\nCALL LBL 5\nL Y+1\nM30\nLBL 5\nL IX+10\nLBL 0"
    assert [tuple(tip.round(9)) for tip in tips(text)] == [(1, 0, 0), (11, 0, 0), (21, 0, 0), (21, 1, 0)]


def test_a_subprogram_at_the_top_runs_in_line_too():
    """LBL 0 ends what was called; met in line it does nothing."""
    assert [tip[0].round(9) for tip in tips("LBL 500\nL IX+10 F100\nLBL 0\nL IX+1\nCALL LBL 500")] == [10, 11, 21]


def test_labels_have_names():
    assert last('CALL LBL "OUT"\nM30\nLBL "OUT"\nL X+7 F100\nLBL 0') == (7, 0, 0)
    assert last('QS3 = "OUT"\nCALL LBL QS3\nM30\nLBL "OUT"\nL X+7 F100\nLBL 0') == (7, 0, 0)


@pytest.mark.parametrize("repeat", ["REP 2", "REP2", "REP 2/2", "REP 2/1"])
def test_a_section_is_repeated_so_many_more_times(repeat):
    assert last(f"LBL 1\nL IX+10 F100\nCALL LBL 1 {repeat}\nL Y+1") == (30, 1, 0)


def test_repeats_within_repeats_and_within_subprograms():
    """The inner repeat begins anew each time it is come by."""
    text = "LBL 1\nLBL 2\nL IX+1 F100\nCALL LBL 2 REP 2\nL IY+1\nCALL LBL 1 REP 1"
    assert last(text) == (6, 2, 0)
    inside = "CALL LBL 9\nCALL LBL 9\nM30\nLBL 9\nLBL 2\nL IX+1 F100\nCALL LBL 2 REP 2\nLBL 0"
    assert last(inside) == (6, 0, 0)


@pytest.mark.parametrize(("number", "test", "times"), [(12, "LT", 5), (9, "EQU", 1), (10, "NE", 5), (11, "GT", 1)])
def test_jumps(number, test, times):
    """FN 9 to FN 12: if equal, not equal, greater, less."""
    text = f"Q1 = 0\nLBL 1\nL IX+1 F100\nQ1 = Q1 + 1\nFN {number}: IF +Q1 {test} +5 GOTO LBL 1"
    assert last(text) == (times, 0, 0)


def test_jump_forward_to_a_name():
    assert last('FN 9: IF +1 EQU +1 GOTO LBL "END"\nL X+9 F100\nLBL "END"\nL Y+1 F100') == (0, 1, 0)


def test_a_loop_without_end_is_one_error():
    with pytest.raises(ProgramError, match="more than 1000 blocks"):
        read("LBL 1\nL IX+1 F100\nFN 9: IF +1 EQU +1 GOTO LBL 1", most_blocks=1000)


def test_a_subprogram_that_calls_itself_is_one_error():
    with pytest.raises(ProgramError, match="nested more than"):
        read("L X+1 F100\nCALL LBL 1\nM30\nLBL 1\nCALL LBL 1\nLBL 0")


def test_a_repeated_section_that_a_jump_leaves_is_said_where_it_is_entered_again():
    """No manual says whether its repetitions begin anew."""
    section = "LBL 1\nL IX+1 F100\nFN 9: IF +Q1 EQU +{} GOTO LBL 9\nQ1 = Q1 + 1\nCALL LBL 1 REP 3\nL Y+5\nM30\n"
    out = "Q1 = 0\n" + section + "LBL 9\nL IY+1\nQ1 = 7\nFN 9: IF +0 EQU +0 GOTO LBL 1"
    said = "goes on counting where it was"
    left, through = (read(out.format(at)) for at in (2, 9))
    assert any(said in each for each in left.assumed) and not any(said in each for each in through.assumed)
    assert through.tip[-1].tolist() == [0.004, 0.005, 0.0]
    inside = "Q1 = 0\nLBL 1\nL IX+1 F100\nQ1 = Q1 + 1\nFN 9: IF +Q1 EQU +2 GOTO LBL 2\nL IY+1\nLBL 2\nCALL LBL 1 REP 3"
    path = read(inside)
    assert path.tip[-1].tolist() == [0.004, 0.003, 0.0] and not any(said in each for each in path.assumed)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CALL LBL 7\nL X+1 F100", "no LBL 7"),
        ("LBL 1\nL X+1 F100\nLBL 1", "LBL 1 stands twice"),
        ("CALL LBL 1\nLBL 1\nL X+1 F100", "end it with LBL 0"),
        ("L X+1 F100\nCALL LBL 1 REP Q1\nLBL 1", "Q1 is not read"),
    ],
)
def test_faults_of_labels(text, message):
    with pytest.raises(ProgramError, match=message):
        read(text)


def test_a_call_of_the_end_ends_the_program():
    """Shops leave a program by CALL LBL 99, which stands before END PGM."""
    made = reader("L X+1 F100\nCALL LBL 99\nLBL 1\nL X+2\nLBL 0\nLBL 99")
    assert made.executed().toolpath().tip[-1, 0] == 0.001
    assert any("CALL LBL 99, which stands before END PGM" in sentence for sentence in made.findings.assumptions)


def test_a_parameter_without_a_value_is_named_and_not_those_that_hang_on_it():
    text = "Q2 = Q1 + 1\nFN 1: Q3 = +Q2 + +1\nL X+Q3 F100\nQ2 = 5\nL Y+Q2"
    made = findings(text)
    assert [(each.word, each.line) for each in made.refusals] == [("Q1", 4)]
    assert last(text, skip_unknown=True) == (0, 5, 0)
    system = findings("FN 18: SYSREAD Q1 = ID270 NR1 IDX1\nL X+Q1 F100\nL X+5")
    assert [each.word for each in system.refusals] == ["FN 18"]
    # values that a program hands to the one that called it
    assert [each.word for each in findings("QL1 = 5\nFN 37: EXPORT QL1\nL X+QL1 F100").refusals] == ["FN 37"]


def test_a_loop_that_hangs_on_a_parameter_without_a_value_is_gone_through_once():
    """What else is not read is found behind the jump; where it is met again, nothing new is."""
    text = "LBL 1\nL IX+1 F100\nFN 12: IF +Q7 LT +1 GOTO LBL 2\nFL X1\nFN 9: IF +0 EQU +0 GOTO LBL 1\nLBL 2\nL IX+9"
    assert [each.word for each in findings(text).refusals] == ["Q7", "FL"]
    assert last(text, skip_unknown=True) == (2, 0, 0)


def test_an_error_that_the_program_raises_is_refused_and_ends_it():
    """FN 14: ERROR: the control shows the error, and the program stops."""
    with pytest.raises(ProgramError, match="FN 14: ERROR= 1005 is not read: the program stops itself with this error"):
        read("L X+1 F100\nFN 14: ERROR= 1005\nFL X2")


def test_stop_and_the_end_of_the_program():
    """STOP, M0, M1 stop; behind M2 and M30 nothing is executed."""
    path = read("L X+1 F100\nSTOP\nL X+2 M0\nL X+3\nL X+4 M30\nL X+99")
    assert list(path.stop) == [True, True, True, False, True] and path.tip[-1, 0] == 0.004


def program(folder, name, text):
    file = folder / name
    file.write_text(text)
    return HeidenhainReader(Source.load(file), None, CONTROLLER, ReadOptions(), Findings())


MAIN = "BEGIN PGM MAIN MM\nL X+0 Y+0 Z+0 FMAX\nQ1 = 5\nQL1 = 1\nCALL PGM {}\nL X+QL1 Y+Q1 F100\nEND PGM MAIN MM\n"
PART = "BEGIN PGM PART INCH\nL X+1 F100\nQ1 = Q1 + 1\nQL1 = 99\nEND PGM PART INCH\n"


@pytest.mark.parametrize("name", ["PART", "PART.H", "TNC:\\JOBS\\part.h", '"Part.h"'])
def test_a_program_beside_is_called(tmp_path, name):
    """CALL PGM: Q parameters are shared, QL are each program's own, and each has its own unit."""
    (tmp_path / "part.h").write_text(PART)
    path = program(tmp_path, "main.h", MAIN.format(name)).executed().toolpath()
    assert path.tip[1:].round(9).tolist() == [[0.0254, 0, 0], [0.001, 0.006, 0]]
    assert path.block.tolist() == [2, 5, 6]


def test_a_selected_program_is_called(tmp_path):
    """SEL PGM, CALL SELECTED PGM (TNC 640, "Calling any NC program as subprogram")."""
    (tmp_path / "part.h").write_text(PART)
    text = MAIN.format("{}").replace("CALL PGM {}", 'SEL PGM "part.h"\nCALL SELECTED PGM')
    path = program(tmp_path, "main.h", text).executed().toolpath()
    assert path.tip[1:].round(9).tolist() == [[0.0254, 0, 0], [0.001, 0.006, 0]]
    with pytest.raises(ProgramError, match="no program is selected here: write SEL PGM before its call"):
        read("CALL SELECTED PGM")
    with pytest.raises(ProgramError, match=r"SEL TABLE .* is not read: write what the table holds"):
        read('SEL TABLE "NULL.D"\nL X+1 F100')


def test_a_program_that_is_not_there_is_refused_with_its_cure(tmp_path):
    with pytest.raises(ProgramError, match=r"main\.h:5: CALL PGM PART is not read: put the file into the folder"):
        program(tmp_path, "main.h", MAIN.format("PART")).executed().toolpath()


def test_a_fault_in_a_called_program_names_its_file(tmp_path):
    (tmp_path / "part.h").write_text("BEGIN PGM PART MM\nL X+\nEND PGM PART MM\n")
    with pytest.raises(ProgramError, match=r"part\.h:2: X has no value"):
        program(tmp_path, "main.h", MAIN.format("PART")).executed().toolpath()


def test_programs_that_call_each_other_are_one_error(tmp_path):
    (tmp_path / "part.h").write_text("BEGIN PGM PART MM\nCALL PGM MAIN\nEND PGM PART MM\n")
    with pytest.raises(ProgramError, match="nested more than"):
        program(tmp_path, "main.h", MAIN.format("PART")).executed().toolpath()


def test_m30_in_a_called_program_is_refused(tmp_path):
    """"The called program must not contain M2 or M30": what stands behind the call was passed over."""
    (tmp_path / "part.h").write_text("BEGIN PGM PART MM\nL X+1 F100 M30\nEND PGM PART MM\n")
    with pytest.raises(ProgramError, match=r"main\.h:5: M2 or M30 in a called program is not read: end it with END"):
        program(tmp_path, "main.h", MAIN.format("PART")).executed().toolpath()
