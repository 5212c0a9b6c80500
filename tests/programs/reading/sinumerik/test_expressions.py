"""Expressions against Python's own arithmetic, and the manual's priorities."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.sinumerik import ends, last, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.coordinates.setup import SetUp, Tool
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.sinumerik.flow.memory import Store
from toolpace.programs.reading.sinumerik.syntax.expressions import OPERATIONS, Parser
from toolpace.programs.reading.sinumerik.syntax.lexer import tokens
from toolpace.programs.reading.sinumerik.syntax.values import Unread, Value


def unknown(name: str, index: tuple[Value, ...]) -> Value:
    raise Unread(name, "")


def value(text: str) -> Value:
    memory = Store({}, unknown)
    memory.r.update({1: 3.0, 2: -0.5, 7: 12.0})
    memory.define("DEPTH", "REAL").set((), 2.5, "DEPTH")
    memory.define("TABLE", "REAL", (3,)).set((1,), 8.0, "TABLE")
    parser = Parser(tokens(text))
    compiled = parser.expression()
    assert parser.token.kind == "end", text
    return compiled(memory)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("2+3*4", 14.0),
        ("(2+3)*4", 20.0),
        ("7 DIV 2", 3),
        ("-7 DIV 2", -3),
        ("7 MOD 4", 3.0),
        ("3/4", 0.75),
        ("10-4-3", 3.0),
        ("100/10/2", 5.0),
        ("-R1*2", -6.0),
        ("SIN(30)+COS(60)", 1.0),
        ("ATAN2(1,-1)", 135.0),
        ("SQRT(POT(3)+POT(4))", 5.0),
        ("ROUND(2.5)+ROUND(-2.5)", 0.0),
        ("TRUNC(-2.7)", -2.0),
        ("BOUND(0,10,12)", 10.0),
        ("MINVAL(3,4)+MAXVAL(3,4)", 7.0),
        ("R[R1+4]", 12.0),
        ("TABLE[1]*DEPTH", 20.0),
        ("1.5EX-3", 0.0015),
        ("'HFF'", 255.0),
        ("'B101'", 5.0),
        ("5 B_AND 6 B_OR 8", 12),
        ("NOT 0 AND 1", True),
        ('"A"<<5<<"B"', "A5B"),
        ("1 B_XOR 3", 2),
    ],
)
def test_values(text, wanted):
    """NC Programming 12/2019, 2.3, 2.15 and 3.1.3: numbers, functions in degrees, DIV whole, / real."""
    found = value(text)
    assert found == wanted if isinstance(wanted, str) else math.isclose(found, wanted, abs_tol=1e-12)


def test_comparisons_bind_weakest():
    """NC Programming, 3.1.3.3: without brackets A==1 AND B==2 is A==(1 AND B)==2."""
    assert value("(R1==3) AND (R7==12)") is True
    assert value("R1==3 AND R7==12") is False


def test_comparisons_are_relative():
    """NC Programming, 3.1.3: REAL numbers are equal when they differ by less than one part in 10^12."""
    assert value("0.1+0.2==0.3") is True and value("0.1+0.2>0.3") is False and value("1==1.0001") is False


_numbers = st.floats(0.001, 1000).map(lambda x: f"{x:.6f}")


def _trees(depth: int = 4) -> st.SearchStrategy[str]:
    return st.recursive(
        _numbers,
        lambda inner: st.one_of(
            st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda t: f"{t[0]}{t[1]}{t[2]}"),
            inner.map(lambda t: f"({t})"),
            inner.map(lambda t: f"-({t})"),
            st.tuples(inner, inner).map(lambda t: f"({t[0]})/(1000000+ABS({t[1]}))"),
        ),
        max_leaves=12,
    )


@settings(max_examples=300, deadline=None)
@given(_trees())
def test_arithmetic_is_pythons(text):
    wanted = eval(text, {"ABS": abs})
    assert math.isclose(value(text), wanted, rel_tol=1e-9, abs_tol=1e-9)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["AND", "OR", "XOR"]), st.booleans()), min_size=1, max_size=6), st.booleans())
def test_logic_is_pythons_with_and_before_xor_before_or(rest, first):
    python = {"AND": " & ", "XOR": " ^ ", "OR": " | "}
    text = str(first).upper() + "".join(f" {word} {str(b).upper()}" for word, b in rest)
    wanted = eval(str(first) + "".join(python[word] + str(b) for word, b in rest))
    assert value(text) is wanted


@pytest.mark.parametrize(
    "text",
    [
        "1/0",
        "5 MOD 0",
        "SQRT(-1)",
        "ASIN(2)",
        "LN(0)",
        "EXP(10000)",
        "1EX299 DIV 1EX-299",
        "EXP(700)*EXP(700)*0+1",
        '"A"+1',
        "TABLE[3]",
    ],
)
def test_what_has_no_value_is_told(text):
    with pytest.raises(BlockError, match=": "):
        value(text)


@pytest.mark.parametrize("text", ["", "1+", "(1", "SIN(1,2)", "SIN()", "5 5 *", "ATAN2(1)", "X5+1"])
def test_what_is_no_expression_is_told(text):
    with pytest.raises((BlockError, AssertionError)):
        value(text)


def test_brackets_have_a_depth():
    assert value("(" * (Parser.deepest - 2) + "1" + ")" * (Parser.deepest - 2)) == 1.0
    with pytest.raises(BlockError, match="brackets"):
        value("(" * 500 + "1" + ")" * 500)


def test_priorities_fall_in_the_manuals_order():
    order = ["*", "+", "B_AND", "B_XOR", "B_OR", "AND", "XOR", "OR", "<<", "=="]
    assert [OPERATIONS[word][0] for word in order] == sorted((OPERATIONS[word][0] for word in order), reverse=True)


def test_a_fault_in_an_expression_names_the_line():
    with pytest.raises(ProgramError, match=r"part\.mpf:3: division by zero"):
        read("G1 X=1/R5")


def test_radii_of_the_sheet():
    """$P_TOOLR and $TC_DP6: of the tool in the spindle, and of a number; refused where the sheet tells none."""
    told, untold = (SetUp(tools={"1": Tool(0.1, radius)}) for radius in (0.004, 0.0))
    for name in ("$P_TOOLR", "$TC_DP6[1,1]"):
        text = f"T1 D1 M6\nG0 X0 Y0 Z0\nG1 X={name}"
        assert last(text, setup=told)[0] == pytest.approx(4)
        with pytest.raises(ProgramError, match="tells no radius of the tool"):
            read(text, setup=untold)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("DEF REAL AB[3]=(1,2,3)", (1, 2, 3)), ("DEF REAL AB[3]=SET(1,2)", (1, 2, 0)),
        ("DEF REAL AB[3]=REP(5)", (5, 5, 5)), ("DEF REAL AB[3]\nAB[1]=REP(4)", (0, 4, 4)),
        ("DEF REAL AB[3]\nAB[1]=SET(4,5)", (0, 4, 5)), ("DEF INT AB[3]=(1.5,R1+2*3,-0.4)", (2, 6, 0)),
    ],
)  # fmt: skip
def test_arrays_that_one_block_fills(text, values):
    """Job Planning, DEF: values from the first element on, or REP for all of them; later SET and REP from any on."""
    assert last(f"{text}\nG1 X=AB[0] Y=AB[1] Z=AB[2]+9") == pytest.approx([values[0], values[1], values[2] + 9])


def test_the_last_index_of_an_array_runs_first():
    text = "DEF REAL AB[2,2]=(1,2,3,4)\nAB[0,1]=SET(7,8)\nG1 X=AB[0,0] Y=AB[0,1] Z=AB[1,0]\nX=AB[1,1]"
    assert ends(text)[-2:] == pytest.approx(np.array([[1, 7, 8], [4, 7, 8]]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("DEF REAL AB[3]=5", r"for all elements, or for the first\?"), ("DEF REAL AB[3]=SET(1,,3)", "SET takes values"),
        ("DEF REAL AB[2]=(1,2,3)", "has 2 elements from there on, not 3"), ("DEF REAL AB[2]=REP(1,2)", "REP takes one"),
        ("DEF REAL AB[9999]=REP(1)", "write a loop"), ("DEF REAL AB=SET(1,2)", "has 1 elements from there on"),
    ],
)  # fmt: skip
def test_rows_of_values_that_cannot_be(text, message):
    with pytest.raises(ProgramError, match=message):
        last(f"{text}\nG1 X1")
