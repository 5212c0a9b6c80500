"""Variables, expressions, loops and calls of Fanuc's Custom Macro B and of LinuxCNC."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.controllers import read_for, tips
from toolpace.common.errors import ProgramError
from toolpace.machine.machine import Machine
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.gcode.program.expressions import Grammar, Parser, value_of
from toolpace.programs.reading.gcode.program.variables import Variables

START = "G90 G21 G94 G17 F100\nG0 X0 Y0 Z0\n"


def value(text: str, *, bits: bool = False, **known: float):
    """What an expression comes to."""
    variables = Variables(
        {name.lstrip("v"): number for name, number in known.items()}, lambda key: None,
        locals_to=33, empty_locals=bits, system_from=1000,
    )  # fmt: skip
    parser = Parser(text, grammar=Grammar(bits=bits))
    found = value_of(parser.expression(), variables)
    assert not parser.text[parser.at :].strip()
    return found


def xs(controller: str, body: str, **options) -> list[float]:
    """X of the points [mm]."""
    return [row[0] for row in tips(controller, START + body, **options)]


# --- expressions --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("1+2*3", 7), ("[1+2]*3", 9), ("2**3", 8), ("10-4-3", 3), ("11 MOD 4", 3), ("-3+5", 2), ("8/4/2", 1),
        ("-7 MOD 4", 1),
        ("SIN[30]", 0.5), ("COS[60]", 0.5), ("TAN[45]", 1), ("ASIN[1]", 90), ("ACOS[0]", 90),
        ("ATAN[1]/[1]", 45), ("ATAN[1]/[-1]", 135), ("SQRT[16]", 4), ("ABS[-2.5]", 2.5), ("LN[EXP[2]]", 2),
        ("FIX[2.8]", 2), ("FUP[2.1]", 3), ("ROUND[2.5]", 3), ("FIX[-2.8]", -3), ("FUP[-2.8]", -2),
        ("2 EQ 2", 1), ("2 NE 2", 0), ("3 GT 2", 1), ("2 GE 2", 1), ("3 LT 2", 0), ("2 LE 2", 1),
        ("1 GT 0 AND 1 LT 0", 0), ("1 GT 0 OR 1 LT 0", 1), ("1 XOR 1", 0), ("2+3 GT 4", 1), (".5*4.", 2),
    ],
)  # fmt: skip
def test_expressions_of_linuxcnc(text, wanted):
    """LinuxCNC, "Binary Operators" (** first, then * / MOD, + -, comparisons, AND OR XOR) and "Functions"."""
    assert value(text) == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("text", "wanted"), [("11 MOD 4", 3), ("FIX[-2.8]", -2), ("FUP[-2.1]", -3), ("6 AND 3", 2), ("4 OR 1+1", 6)]
)
def test_expressions_of_fanuc(text, wanted):
    """Fanuc 16i operator's manual, 15.3: FIX and FUP by magnitude, AND binds like *, OR like +, on bits."""
    assert value(text, bits=True) == wanted


def test_an_empty_variable_is_zero_in_sums_and_equal_to_an_empty_one_only():
    """Fanuc 16i, 15.1 "Undefined variable": #1 EQ #0 holds where #1 is empty, #1 EQ 0 does not; #1+1 is 1."""
    assert value("#1 EQ #0", bits=True) == 1 and value("#1 EQ 0", bits=True) == 0 and value("#1+1", bits=True) == 1
    assert value("#1 GE 0", bits=True) == 1 and value("#1", bits=True) is None


def test_variables_by_number_by_a_number_that_is_reckoned_and_by_name():
    assert value("#[100+1]", v101=5) == 5 and value("##100", v100=101, v101=7) == 7
    assert value("#<_DEEP END>*2", **{"v#<_DEEPEND>": 3}) == 6


SAFE = st.one_of(st.integers(0, 50).map(float), st.floats(0.001, 99).map(lambda x: round(x, 3)))


def trees():
    return st.recursive(
        SAFE.map(lambda x: (f"{x:.3f}", x)),
        lambda inner: st.tuples(inner, st.sampled_from("+-*"), inner).map(
            lambda t: (f"[{t[0][0]} {t[1]} {t[2][0]}]", {"+": t[0][1] + t[2][1], "-": t[0][1] - t[2][1],
                                                        "*": t[0][1] * t[2][1]}[t[1]])
        ),
        max_leaves=12,
    )  # fmt: skip


@settings(max_examples=200, deadline=None, derandomize=True)
@given(trees())
def test_any_expression_comes_to_what_python_makes_of_it(tree):
    text, wanted = tree
    for bits in (False, True):
        assert value(text, bits=bits) == pytest.approx(wanted)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.integers(1, 9), st.sampled_from(["+", "-", "*", "/"])), min_size=1, max_size=12))
def test_precedence_is_that_of_python_for_sums_and_products(parts):
    text = "".join(f"{number}{operation}" for number, operation in parts) + "1"
    assert value(text) == pytest.approx(eval(text))


@pytest.mark.parametrize(
    "text", ["1/0", "SQRT[-1]", "ASIN[2]", "LN[0]", "[1", "SIN 3", "FOO[1]", "1+", "#<a", "[" * 99]
)
def test_expressions_that_cannot_be(text):
    with pytest.raises(BlockError):
        value(text)


# --- loops and jumps ------------------------------------------------------------------------------------------------


def test_while_of_fanuc_runs_as_long_as_it_holds():
    """Fanuc 16i, 15.5.3 "Repetition (WHILE statement)"."""
    assert xs("fanuc", "#1=1\nWHILE [#1 LE 3] DO1\nG1 X[#1*2]\n#1=#1+1\nEND1\nM30") == [0, 2, 4, 6]


def test_loops_of_fanuc_are_nested_and_their_numbers_used_again():
    body = "#2=0\n#1=0\nWHILE[#1 LT 2]DO1\n#3=0\nWHILE[#3 LT 2]DO2\n#2=#2+1\nG1 X#2\n#3=#3+1\nEND2\n#1=#1+1\nEND1\n"
    assert xs("fanuc", body + "WHILE[#2 LT 6]DO1\n#2=#2+1\nG1 X#2\nEND1\nM30") == [0, 1, 2, 3, 4, 5, 6]


def test_jumps_of_fanuc():
    """Fanuc 16i, 15.5.1 "Unconditional branch" and 15.5.2 "IF statement"; THEN sets."""
    assert xs("fanuc", "G1 X1\nGOTO 20\nX9\nN20 X2\nM30") == [0, 1, 2]
    body = "#1=0\nN10 #1=#1+1\nG1 X#1\nIF [#1 LT 3] GOTO 10\nIF [#1 EQ 3] THEN #2=7\nX#2\nM30"
    assert xs("fanuc", body) == [0, 1, 2, 3, 7]


def test_an_empty_variable_drops_its_word():
    """Fanuc 16i, 15.1: an address with an undefined variable is ignored."""
    assert tips("fanuc", START + "G1 X5 Y#1\nM30")[-1] == [5, 0, 0]


def test_o_words_of_linuxcnc():
    """LinuxCNC, "O Codes": while, do, if, repeat, break, continue."""
    assert xs("linuxcnc", "#1=0\no1 while [#1 LT 3]\n#1=[#1+1]\nG1 X#1\no1 endwhile\nM2") == [0, 1, 2, 3]
    assert xs("linuxcnc", "#1=0\no1 do\n#1=[#1+1]\nG1 X#1\no1 while [#1 LT 3]\nM2") == [0, 1, 2, 3]
    assert xs("linuxcnc", "#1=0\no1 repeat [3]\n#1=[#1+1]\nG1 X#1\no1 endrepeat\nM2") == [0, 1, 2, 3]
    body = (
        "#1=0\no1 while [1]\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 elseif [#1 GT 4]\no1 break\no2 endif\nG1 X#1\n"
    )
    assert xs("linuxcnc", body + "o1 endwhile\nX9\nM2") == [0, 1, 3, 4, 9]


@pytest.mark.parametrize(("number", "x"), [(1, 10), (2, 20), (3, 30), (4, 40)])
def test_one_branch_of_an_if_is_run(number, x):
    body = (
        "o1 if [#1 EQ 1]\nG1 X10\no1 elseif [#1 EQ 2]\nG1 X20\no1 elseif [#1 EQ 3]\nG1 X30\no1 else\nG1 X40\no1 endif\n"
    )
    assert xs("linuxcnc", f"#1={number}\n{body}M2") == [0, x]


# --- calls ------------------------------------------------------------------------------------------------------------


def test_subprograms_with_arguments_and_locals_of_their_own():
    """LinuxCNC, "Subroutines": arguments are #1 to #30 of the call; names without _ are the call's own."""
    body = "o1 sub\n#<far>=[#1+#2]\nG1 X#<far>\no1 endsub [#<far>*2]\n#<far>=1\no1 call [3] [4]\n"
    body += "G1 Y#<_value>\nX#<far>\nM2"
    assert tips("linuxcnc", START + body)[1:] == [[7, 0, 0], [7, 14, 0], [1, 14, 0]]


def test_m98_calls_so_often_and_m99_returns():
    """Fanuc 0i, 12.3: M98 P L; of older ones P51002 is five times O1002."""
    sub = "M30\nO1000\nG91 G1 X1\nG90\nM99"
    assert xs("fanuc", f"M98 P1000 L3\n{sub}") == [0, 1, 2, 3]
    assert xs("fanuc", f"M98 P21000\n{sub}") == [0, 1, 2]


def test_m97_of_haas_calls_a_block_of_the_same_program():
    """Haas mill manual, M97: a subprogram that begins with the block N of P, and ends with M99."""
    assert xs("haas", "M97 P100 L2\nG1 X9\nM30\nN100 G91 G1 X1\nG90 M99") == [0, 1, 2, 9]


def test_g65_gives_letters_to_variables():
    """Fanuc 16i, 15.7.1 "Simple call": A is #1, B #2, C #3, I #4, J #5, K #6, X #24, Y #25; the call has its own."""
    body = "#1=50\nG65 P2000 A1.5 X4. I2. J3. I6.\nG1 X#1\nM30\nO2000\nG1 X[#1+#24] Y[#4+#5]\nX#7\nM99"
    assert tips("fanuc", START + body)[1:] == [[5.5, 5, 0], [6, 5, 0], [50, 5, 0]]


def test_programs_beside_the_file_are_called(tmp_path):
    (tmp_path / "O1234.nc").write_text("O1234\nG1 X7 F100\nM99\n")
    (tmp_path / "drive.ngc").write_text("o<drive> sub\nG1 X#1\no<drive> endsub\nM2\n")
    main = tmp_path / "main.nc"
    main.write_text("")
    assert tips("fanuc", START + "M98 P1234\nX8\nM30", name=str(main))[1:] == [[7, 0, 0], [8, 0, 0]]
    assert tips("linuxcnc", START + "o<drive> call [5]\nM2", name=str(main))[1:] == [[5, 0, 0]]


def test_positions_are_read_back_in_the_units_of_the_program():
    """Fanuc: #5001 is X at the end of the last block. LinuxCNC: #5420."""
    assert xs("fanuc", "G20 G1 X2.\nX[#5001+1.]\nM30")[-1] == pytest.approx(76.2)
    assert xs("linuxcnc", "G1 X2\nX[#5420+1]\nM2")[-1] == 3


def test_machine_coordinates_that_are_read_are_those_that_g53_goes_to():
    """B-63944EN, custom macro: #5021 is the position in machine coordinates, in units of the program."""
    machine = Machine.load("xyzac-trunnion")
    sheet = SetUp(offsets={"G55": {"X": -0.1, "Z": -0.05}}, machine_zero={"X": 0.0, "Y": 0.0, "Z": 0.3})
    there = "G55 G0 X2. Y3. Z4. A0 C0\n#100=#5021\n#101=#5023\nX0 Y0 Z0\n"
    path = read_for("fanuc", f"{there}G53 G0 X#100 Z#101\nG20 G0 Y[#5022-#5022+1.]\nM30", machine, setup=sheet)
    at = [row - path.tip[0] for row in path.tip]
    assert at[2] == pytest.approx([0, -0.003, 0], abs=1e-12) and at[3] == pytest.approx([0, 0.0224, 0], abs=1e-12)
    said = read_for("fanuc", "G0 X1. Y2. Z3. A0 C0\nX[#5021-#5021]\nM30", machine).assumed
    assert any("that the program reads count from the upper ends" in sentence for sentence in said)


@pytest.mark.parametrize(
    "controller, words, number, value",
    [
        ("fanuc", "", 4005, 94), ("fanuc", "G93", 4005, 93), ("fanuc", "G55", 4014, 55), ("haas", "G56", 4012, 56),
        ("fanuc", "F250", 4109, 250), ("fanuc", "S800", 4119, 800), ("fanuc", "G80", 4009, 80),
        ("fanuc", "G54.1 P3", 4014, 54), ("fanuc", "G21", 4006, 21),
    ],
)  # fmt: skip
def test_codes_and_words_in_force_are_read(controller, words, number, value):
    text = START + f"{words}\n#100=#{number}\nG94 G54 F100\nG1 X[#100-{value}+7]\nM30"
    assert read_for(controller, text).tip[-1, 0] == pytest.approx(0.007)


def test_the_unit_in_force_is_read():
    """B-63944EN, custom macro: #4006 is 20 in inches and 21 in millimetres."""
    assert xs("fanuc", "G20\n#100=#4006\nG21 G1 X#100\nM30")[-1] == 20


def test_the_set_up_sheet_sets_variables():
    assert xs("fanuc", "G1 X#500\nM30", setup=SetUp(variables={"#500": 12.5})) == [0, 12.5]


@pytest.mark.parametrize(
    ("controller", "body", "says"),
    [
        ("fanuc", "G1 X#100", "#100 is not read: set it before"),
        ("linuxcnc", "G1 X#<depth>", "#<depth> is not read: set it before"),
        ("fanuc", "IF [#100 EQ 1] GOTO 5", "#100 is not read: set it before"),
        ("fanuc", "GOTO 7", "no block N7"), ("fanuc", "M98 P7", "is not in this file"),
        ("fanuc", "WHILE [1 EQ 1] DO1\nX1", "lacks its beginning or its end"),
        # B-63944EN, "Repetition": crossing loops (overlapped DO ranges) are alarm PS0124
        ("fanuc", "WHILE [#1 LT 1] DO1\n#1=1\nWHILE [#2 LT 1] DO2\nEND1\n#2=1\nEND2", "DO2 crosses the loop of line"),
        ("fanuc", "DO4", "the numbers 1, 2 and 3"),
        ("fanuc", "#5221=4", "set offsets with G10"), ("fanuc", "N1 GOTO 1", "a loop without end"),
        ("fanuc", "O5 (HERE)\nM98 P5", "nested more than 64 deep"), ("fanuc", "IF [1] X5", "GOTO or THEN is missing"),
        ("linuxcnc", "o1 if [1 GT 2]\nX1", "has no endif"), ("linuxcnc", "o1 break", "stands in no loop"),
        ("linuxcnc", "o1 while [1]\no1 endwhile", "a loop without end"),
        ("linuxcnc", "o1 if\no1 endif", "takes one value"),
        ("linuxcnc", "o1 repeat [2] @9\no1 endrepeat", "'@9' has no meaning behind repeat"),
        ("linuxcnc", "#1=[1/0]", "division by zero"), ("linuxcnc", "#1 5", "write = and a value"),
        ("fanuc", "G65 A1", "needs the macro's number"),
        ("fanuc", "G65 P2000 A1 ,R5\nM30\nO2000\nM99", ",R is no argument of a macro: remove it"),
    ],
)  # fmt: skip
def test_flow_that_cannot_be_ends_in_one_clear_error(controller, body, says):
    with pytest.raises(ProgramError, match=says.replace("[", r"\[")) as caught:
        read_for(controller, START + body + "\nG1 X2\nM30\n", most_blocks=5000)
    assert "\n" not in str(caught.value) and str(caught.value).startswith("part.nc:")


def test_a_hundred_thousand_blocks_of_a_loop_cost_little_each():
    """A circle by expressions, and a cycle: as many calls of Python a block as a plain program, within a factor."""
    from tests.support.growth import python_calls

    def body(n):
        loop = f"WHILE [#1 LT {n}] DO1\n#1=#1+1\nX[10.*COS[#1]] Y[10.*SIN[#1]]\nEND1\n"
        return f"{START}#1=0\nG99 G81 X0 Z-1. R1.\n{loop}G80\nM30"

    few, many = (python_calls(lambda n=n: read_for("fanuc", body(n))) for n in (100, 1100))
    assert (many - few) / 1000 < 400
    path = read_for("fanuc", body(50))
    assert math.hypot(*path.tip[-1, :2]) == pytest.approx(0.01, abs=0.8e-6)  # words are rounded to 0.001 mm
