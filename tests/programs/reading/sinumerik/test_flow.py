"""Jumps, loops, calls (Job Planning, chapter 1; Fundamentals, program jumps and repetitions)."""

from __future__ import annotations

import math

import pytest

from tests.support.sinumerik import START, ends, last, read
from toolpace.common.errors import ProgramError


def xs(text: str, **options) -> list[float]:
    """X [mm] at the ends of motions, in order."""
    return [round(x, 9) for x in read(text, **options).tip[1:, 0] * 1e3]


def test_if_else():
    text = "R1={}\nIF R1==1\nG1 X1\nELSE\nG1 X2\nENDIF\nX9"
    assert xs(text.format(1)) == [1, 9] and xs(text.format(5)) == [2, 9]


def test_nested_choices_and_loops():
    text = "FOR R1=1 TO 3\nIF R1<>2\nWHILE R2<2\nG1 X=R1*10+R2\nR2=R2+1\nENDWHILE\nELSE\nX50\nENDIF\nR2=0\nENDFOR"
    assert xs(text) == [10, 11, 50, 30, 31]


def test_for_counts_by_one_and_may_not_run_at_all():
    assert xs("DEF INT NUM\nFOR NUM=5 TO 7\nG1 X=NUM\nENDFOR") == [5, 6, 7]
    assert xs("FOR R1=5 TO 4\nG1 X7\nENDFOR\nG1 X1") == [1]


def test_repeat_until_runs_once_at_least_and_loop_is_left_by_a_jump():
    assert xs("REPEAT\nR1=R1+1\nG1 X=R1\nUNTIL R1>=3") == [1, 2, 3]
    assert xs("LOOP\nR1=R1+1\nG1 X=R1\nIF R1==2 GOTOF DONE\nENDLOOP\nDONE: G1 X9") == [1, 2, 9]


def test_jumps_look_forward_and_back():
    """GOTOF looks from here to the end, GOTOB to the beginning: a label that stands twice is found in its direction."""
    assert xs("PART: R1=R1+1\nG1 X=R1\nIF R1<3 GOTOB PART\nGOTOF PART\nG1 X99\nPART: G1 X50") == [1, 2, 3, 50]
    assert xs("N10 R1=R1+1\nN20 G1 X=R1\nIF R1<2 GOTO N10\nGOTO N50\nG1 X99\nN50 G1 X7") == [1, 2, 7]


def test_a_jump_without_target_is_told():
    with pytest.raises(ProgramError, match="no label NOWHERE below"):
        read("G1 X1\nGOTOF NOWHERE")
    assert xs("G1 X1\nGOTOC NOWHERE\nX2") == [1, 2]


def test_case():
    text = (
        "R1={}\nCASE(R1) OF 1 GOTOF ONE 2 GOTOF TWO DEFAULT GOTOF OTHER\n"
        "ONE: G1 X1\nGOTOF DONE\nTWO: G1 X2\nGOTOF DONE\nOTHER: G1 X3\nDONE: X9"
    )
    assert [xs(text.format(k)) for k in (1, 2, 7)] == [[1, 9], [2, 9], [3, 9]]


def test_repetitions_of_a_part():
    """REPEAT LABEL P=n runs from the label to it n times more, REPEATB one block, two labels what is between."""
    assert xs("PART: R1=R1+1\nG1 X=R1\nREPEAT PART P=2\nX9") == [1, 2, 3, 9]
    assert xs("ONE: G1 X=IC(1)\nX=IC(5)\nREPEATB ONE P=3") == [1, 6, 7, 8, 9]
    assert xs("AA: G1 X=IC(1)\nBB: X=IC(2)\nX=IC(10)\nREPEAT AA BB P2") == [1, 3, 13, 14, 16, 17, 19]
    assert xs("AA: G1 X=IC(1)\nENDLABEL:\nX=IC(10)\nREPEAT AA") == [1, 11, 12]


def test_subprograms_with_arguments():
    """Empty arguments take the defaults; variables of a subprogram are its own; values are passed, not names."""
    main = 'DEF REAL WIDE=4\nBOX(WIDE,,"x")\nG1 X=WIDE\n'
    assert xs(main + "M30\nPROC BOX(REAL WIDE, REAL HIGH=7, STRING[8] SAID)\nWIDE=WIDE+1\nG1 X=WIDE+HIGH\nRET") == [
        12,
        4,
    ]


def test_a_parameter_of_var_is_the_variable_itself():
    """Job Planning, "Subprogram call with parameter transfer", call by reference: what the subprogram writes stays."""
    text = (
        "DEF REAL AT[2], STEP=3\nEXTERN STEPS(VAR REAL[2], VAR REAL, REAL)\nAT[0]=1\nSTEPS(AT, STEP, 10)\n"
        "G1 X=AT[0] Y=AT[1]\nX=STEP\nM30\n"
        "PROC STEPS(VAR REAL PLACE[2], VAR REAL BY, REAL MORE)\nPLACE[0]=PLACE[0]+MORE\nPLACE[1]=BY\nBY=BY+4\nRET"
    )
    assert ends(text)[1:].tolist() == [[11, 3, 0], [7, 3, 0]]


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("SUB1(5)", "hand over a variable"),
        ("SUB1(COUNT+1)", "hand over a variable"),
        ("SUB1(WHOLE)", "stands for a variable of type INT"),
        ("SUB2(LIST)", "write VAR before its type"),
    ],
)
def test_what_var_may_not_stand_for(call, said):
    subprograms = "PROC SUB1(VAR REAL A_IN)\nRET\nPROC SUB2(REAL B_IN)\nRET"
    with pytest.raises(ProgramError, match=said):
        read(f"DEF REAL COUNT, LIST[2]\nDEF INT WHOLE\n{call}\nG1 X1\nM30\n{subprograms}")


def test_a_percent_sign_alone_is_passed_over():
    assert xs("%\nG1 X1\n % \nX2\n%") == [1, 2]


def test_subprograms_by_number_and_their_repetitions():
    """L7 is not L07: leading zeros count (Fundamentals, names of subprograms)."""
    text = "L7 P3\nL07\nM30\n%_N_L7_SPF\nG1 X=IC(1)\nM17\n%_N_L07_SPF\nG1 X100\nM17"
    assert xs(text) == [1, 2, 3, 100]


def test_the_main_program_of_a_file_of_several():
    """The file that ends in MPF is the main program, wherever it stands."""
    head = "%_N_SUB1_SPF\nG1 X=IC(2)\nM17\n%_N_PART_MPF\n;$PATH=/_N_WKS_DIR\n"
    assert xs("SUB1\nSUB1", start=head + START) == [2, 4]


def test_a_subprogram_beside_the_program(tmp_path):
    (tmp_path / "FINISH.SPF").write_text("PROC FINISH(REAL A_TO)\nG1 X=A_TO\nRET\n")
    program = tmp_path / "part.mpf"
    program.write_text("")
    assert xs('FINISH(5)\nCALL "finish"', name=str(program)) == [5, 0]
    # EXTCALL("<program name>") (Job Planning, "External subprograms")
    assert xs('FINISH(5)\nEXTCALL("finish")', name=str(program)) == [5, 0]


def test_save_gives_the_modes_back():
    assert xs("SUB1\nX=5\nM30\nPROC SUB1 SAVE\nG91 G1 X1\nX1\nRET") == [1, 2, 5]
    assert xs("SUB1\nG1 X=5\nM30\nPROC SUB1\nG91 G1 X1\nRET") == [1, 6]


def test_mcall_runs_behind_every_block_with_an_axis():
    """Fundamentals, modal call: also where the axis does not travel, and not within the subprogram itself."""
    text = "MCALL DOWN(5)\nG1 X10\nX10\nR1=1\nMCALL\nX20\nM30\nPROC DOWN(REAL DEEP)\nZ=-DEEP\nZ0\nRET"
    assert ends(text).tolist() == [
        [0, 0, 0], [10, 0, 0], [10, 0, -5], [10, 0, 0], [10, 0, -5], [10, 0, 0], [20, 0, 0]
    ]  # fmt: skip


def test_variables_have_types():
    assert last("DEF INT NUM=2.6\nDEF BOOL YES=5\nG1 X=NUM Y=YES") == [3, 1, 0]
    assert last("DEF REAL LIST[2,3]\nLIST[1,2]=7\nG1 X=LIST[1,2] Y=LIST[0,0]") == [7, 0, 0]
    with pytest.raises(ProgramError, match="LIST has 1 indices, not 2"):
        read("DEF REAL LIST[3]\nLIST[1,1]=1")
    with pytest.raises(ProgramError, match="R-1 is no R parameter"):
        read("R[-1]=5")


def test_a_variable_that_is_not_defined_is_refused_and_reading_goes_on():
    with pytest.raises(ProgramError) as caught:
        read("NOVAR=5\nG1 X=NOVAR\nWHILE NOVAR<5\nX1\nENDWHILE\nFOOBAR\nX2")
    assert "3 kinds of words" in str(caught.value) and "FOOBAR" in str(caught.value)


def test_recursion_and_loops_without_end_are_told():
    with pytest.raises(ProgramError, match="does SUB1 call itself"):
        read("SUB1\nM30\nPROC SUB1\nSUB1\nRET")
    with pytest.raises(ProgramError, match="more than 5000 blocks"):
        read("LOOP\nENDLOOP", most_blocks=5000)
    with pytest.raises(ProgramError, match="more than 5000 blocks"):
        read("AA: R1=1\nGOTOB AA", most_blocks=5000)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("IF R1==0\nX1", "IF is never closed"),
        ("ENDFOR", "ENDFOR stands without its FOR"),
        ("FOR R=1 TO 2\nENDFOR", "FOR needs a variable: write it like FOR I=1 TO 5, or FOR R1=1 TO 5"),
        ("FOR R1=1 TO 2\nENDWHILE\nENDFOR", "ENDWHILE stands without its WHILE, the last open one is FOR"),
    ],
)
def test_structures_without_partner_are_told(text, said):
    with pytest.raises(ProgramError, match=said):
        read(text)


def test_skipped_blocks_and_labels_behind_numbers():
    assert xs("/N10 G1 X5\nN20 /1 X6\nN30 AA: G1 X7") == [7]
    assert xs("/N10 G1 X5\nX7", block_delete=False) == [5, 7]


def test_blocks_of_one_shape_are_compiled_once():
    """100 000 blocks with variables are read in seconds: what differs in its numbers alone is looked up."""
    from toolpace.programs.reading.sinumerik.syntax.statements import _exact, _shaped

    before = _shaped.cache_info().misses + _exact.cache_info().misses
    lines = [f"N{k} G1 X=R1+{k / 8} Y{k}.5 Z=R2*{k}-SIN({k}) F{1000 + k}" for k in range(2000)]
    found = read("R1=7 R2=0\n" + "\n".join(lines)).tip * 1e3
    assert _shaped.cache_info().misses + _exact.cache_info().misses - before < 10
    assert found[-1].tolist() == pytest.approx([7 + 1999 / 8, 1999.5, -math.sin(math.radians(1999))])


def test_ret_that_goes_on_elsewhere_is_refused():
    """Job Planning, "Parameterizable subprogram return": RET("AA") goes on at AA of the caller."""
    with pytest.raises(ProgramError, match="RET with a block to go on at"):
        read('SUB1\nG1 Y5\nAA: G1 Z1\nM30\nPROC SUB1\nG1 X1\nRET("AA")')
    assert read("SUB1\nG1 Y5\nM30\nPROC SUB1\nG1 X1\nRET()").tip[-1] * 1e3 == pytest.approx([1, 5, 0])
