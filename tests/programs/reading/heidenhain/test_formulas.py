"""Q parameters: TNC 640 Klartext manual, "Programming Q parameters"."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.heidenhain import SetUp, findings, last, read
from toolpace.common.errors import ProgramError
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.heidenhain.parameters import Parameters, evaluate, formula


def value(text, **given):
    return evaluate(formula(text, Parameters(given)))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("5 * 3 + 2 * 10", 35),  # "Rules for formulas": multiplication before addition
        ("SQ 10 - 3^3", 73),  # the second example of the same page
        ("SQRT 25", 5),
        ("SIN 30", 0.5),
        ("COS -60", 0.5),
        ("TAN 45", 1),
        ("ASIN 0.5", 30),
        ("ACOS 0.5", 60),
        ("ATAN 1", 45),
        ("LN EXP 2", 2),
        ("LOG 1000", 3),
        ("NEG 3", -3),
        ("INT -3.7", -3),
        ("ABS -3", 3),
        ("FRAC 3.25", 0.25),
        ("SGN -9", -1),
        ("SGN 0", 0),
        ("PI", math.pi),
        ("400 % 360", 40),
        ("2 * ( 3 + 4,5 )", 15),
        ("SIN 180", 0),
        ("COS 90", 0),
        ("+5 LEN +12", 13),
        ("+10 ANG +10", 45),
        ("-1 ANG +0", 270),
        ("+4 DIV +2", 2),
        ("- ( 2 + 1 )", -3),
        ("2 ^ -1", 0.5),
        ("10 - 4 - 3", 3),
        ("24 / 4 / 2", 3),
    ],
)
def test_formulas(text, expected):
    assert value(text) == pytest.approx(expected, abs=1e-14)


def test_the_example_of_the_task_of_formulas():
    assert value("(Q2+3)*SIN Q4", Q2=2.0, Q4=30.0) == pytest.approx(2.5)
    assert value("SINQ4", Q4=30.0) == pytest.approx(0.5)


@pytest.mark.parametrize("text", ["2^3^2", "-Q1^2", "SQ Q1^2"])
def test_what_the_manual_does_not_order_needs_brackets(text):
    with pytest.raises(BlockError, match="needs brackets"):
        value(text, Q1=3.0)


@pytest.mark.parametrize(
    "text", ["1/0", "SQRT -1", "LN 0", "ASIN 2", "(1", "1)", "1+", "HOP 3", "", "1 2", "9^999", "%", "(-8)^(1/3)"]
)
def test_formulas_without_a_value_are_one_error(text):
    with pytest.raises(BlockError):
        value(text)


@pytest.mark.parametrize("text", ["Q1/Q2", "SQRT(Q2-1)", "(Q1*1000)^Q1*Q1^Q1"])
def test_what_fails_where_it_is_executed_is_one_error_too(text):
    with pytest.raises(BlockError):
        value(text, Q1=300.0, Q2=0.0)


def test_brackets_and_operators_have_an_end():
    for text in ("(" * 500 + "1" + ")" * 500, "NEG " * 500 + "1", "1" + "+Q1" * 5000, "1" + "+1" * 5000):
        with pytest.raises(BlockError, match="more than"):
            value(text, Q1=1.0)


class Written:
    """A formula as it is written in Klartext, and its value by Python."""

    def __init__(self, text, value):
        self.text, self.value = text, value


NAMES = {"Q1": 2.5, "QR2": -7.25, "QL3": 0.125}
LEAVES = st.one_of(
    st.integers(0, 999).map(lambda n: Written(f"{n}", float(n))),
    st.integers(1, 99999).map(lambda n: Written(f"{n / 1000:.3f}", n / 1000)),
    st.sampled_from([Written(name, value) for name, value in NAMES.items()]),
)
BY_PYTHON = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "%": math.fmod,
}
FUNCTIONS = {
    "SQ": lambda a: a * a,
    "SIN": lambda a: math.sin(math.radians(a)),
    "COS": lambda a: math.cos(math.radians(a)),
    "ATAN": lambda a: math.degrees(math.atan(a)),
    "ABS": abs,
    "NEG": lambda a: -a,
    "INT": math.trunc,
}


def grown(inner):
    def pair(sign, a, b):
        wanted = BY_PYTHON[sign](a.value, b.value) if b.value or sign in "+-*" else None
        return Written(f"({a.text}){sign}({b.text})", wanted)

    def of(name, a):
        return Written(f"{name} ({a.text})", FUNCTIONS[name](a.value))

    return st.one_of(
        st.builds(pair, st.sampled_from(sorted(BY_PYTHON)), inner, inner).filter(lambda w: w.value is not None),
        st.builds(
            lambda n, a: Written(f"{n} ({a.text})", FUNCTIONS[n](a.value)), st.sampled_from(sorted(FUNCTIONS)), inner
        ),
    )


@settings(max_examples=400, deadline=None, derandomize=True)
@given(st.recursive(LEAVES, grown, max_leaves=12))
def test_random_formulas_are_what_python_says(written):
    parameters = Parameters({"Q1": NAMES["Q1"], "QR2": NAMES["QR2"]})
    parameters.local["QL3"] = NAMES["QL3"]
    found = evaluate(formula(written.text, parameters))
    assert found == pytest.approx(written.value, rel=1e-9, abs=1e-9 * max(1.0, abs(written.value)))


@settings(max_examples=400, deadline=None, derandomize=True)
@given(st.lists(st.tuples(st.sampled_from("+-*"), st.integers(1, 9)), min_size=1, max_size=8), st.integers(1, 9))
def test_chains_without_brackets_have_pythons_precedence(rest, first):
    text = str(first) + "".join(f" {sign} {number}" for sign, number in rest)
    assert value(text) == eval(text)


@settings(max_examples=500, deadline=None, derandomize=True)
@given(st.text(alphabet="Q1234.,+-*/^%() SINCOSQRTLENANGPIDV", max_size=40))
def test_anything_spelt_like_a_formula_is_a_number_or_one_error(text):
    try:
        assert math.isfinite(value(text, Q1=1.0, Q2=0.0))
    except BlockError as error:
        assert str(error)
    except Exception as error:
        assert type(error).__name__ == "UnsetError"


# In programs


def test_parameters_in_words():
    assert last("Q1 = 3\nQL2 = 4\nQR3 = 5\nL X+Q1 Y-QL2 ZQR3 F100") == (3, -4, 5)
    assert last("Q1 = 3\nL X+1 FQ1\nL IX+Q1") == (4, 0, 0)


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        ("FN 0: Q5 = +1.5", 1.5),
        ("FN 1: Q5 = -Q2 + -5", -7),
        ("FN 2: Q5 = +10 - +5", 5),
        ("FN 3: Q5 = +3 * +3", 9),
        ("FN 4: Q5 = +4 DIV +Q2", 2),
        ("FN 5: Q5 = SQRT 4", 2),
        ("FN 6: Q5 = SIN +90", 1),
        ("FN 7: Q5 = COS -180", -1),
        ("FN 8: Q5 = +5 LEN +12", 13),
        ("FN 13: Q5 = +25 ANG +25", 45),
        ("FN0:Q5=+3", 3),
    ],
)
def test_fn_functions(block, expected):
    """ "Describing contours with mathematical functions", "Angle functions"."""
    assert last(f"Q2 = 2\n{block}\nL X+Q5 Y+1 F100")[0] == pytest.approx(expected)


def test_a_parameter_without_a_value_is_refused_and_reading_goes_on():
    found = findings("L X+Q5 F100\nL X+Q6\nL Y+1 F100")
    assert [(refusal.word, refusal.line) for refusal in found.refusals] == [("Q5", 4), ("Q6", 5)]


def test_the_set_up_sheet_gives_parameters():
    assert last("L X+Q5 F100", setup=SetUp(variables={"Q5": 12.0})) == (12, 0, 0)


def test_system_reads_are_refused_and_messages_ignored():
    found = findings("FN 18: SYSREAD Q5 = ID20 NR1\nFN 16: F-PRINT A.TXT / B.TXT\nL X+1 F100")
    assert [refusal.word for refusal in found.refusals] == ["FN 18"]
    assert found.skipped["FN 16"] == 1


def test_a_result_beyond_all_bounds_is_one_error():
    with pytest.raises(ProgramError, match="beyond any machine"):
        read("Q1 = 900000000\nQ1 = Q1 * Q1\nL X+Q1 F100")
