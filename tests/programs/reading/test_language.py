"""What all languages have in common: expressions against Python's own arithmetic, and the flow from block to block."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text
from toolpace.programs.reading.expressions import BlockError
from toolpace.programs.reading.flow import CALL, MAIN, PART, CallStack, Frame, Labels, Nesting, times

WRITTEN = {
    "fanuc": ("G21 G90 F1000\n#1={0}\nG0 X0 Y0 Z0\nG1 X[#1]\nM30\n", "[", "]", "{}[{}]"),
    "linuxcnc": ("G21 G90 F1000\n#1=[{0}]\nG0 X0 Y0 Z0\nG1 X[#1]\nM2\n", "[", "]", "{}[{}]"),
    "sinumerik": ("G71 G90 F1000\nR1={0}\nG0 X0 Y0 Z0\nG1 X=R1\nM30\n", "(", ")", "{}({})"),
    "heidenhain": (
        "BEGIN PGM A MM\nQ1 = {0}\nL X+0 Y+0 Z+0 FMAX\nL X+Q1 F1000\nEND PGM A MM\n", "(", ")", "{} ({})"
    ),
}  # fmt: skip
"""A program that goes to the value of an expression [mm], the brackets, and how a function of a value is written."""
FUNCTIONS = {
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "SQRT": math.sqrt,
    "ABS": abs,
}
OPERATORS = {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b}
NUMBERS = st.integers(1, 9999).map(lambda n: n / 100)


def trees(depth):
    """Expressions as nested tuples."""
    if depth == 0:
        return NUMBERS
    inner = trees(depth - 1)
    return st.one_of(
        NUMBERS,
        st.tuples(st.just("-"), inner),
        st.tuples(st.sampled_from(sorted(FUNCTIONS)), inner),
        st.tuples(inner, st.sampled_from(sorted(OPERATORS)), inner),
    )


def value(tree):
    """By Python's own arithmetic."""
    if isinstance(tree, float):
        return tree
    if len(tree) == 3:
        return OPERATORS[tree[1]](value(tree[0]), value(tree[2]))
    return -value(tree[1]) if tree[0] == "-" else FUNCTIONS[tree[0]](value(tree[1]))


def written(tree, language):
    """The expression in a language, with brackets where they are needed."""
    _, opening, closing, call = WRITTEN[language]
    if isinstance(tree, float):
        return f"{tree:.2f}"
    if len(tree) == 2 and tree[0] != "-":
        return call.format(tree[0], written(tree[1], language))
    parts = [
        f"{opening}{written(part, language)}{closing}" if isinstance(part, tuple) else written(part, language)
        for part in (tree[1:] if len(tree) == 2 else tree[0::2])
    ]
    return f"-{parts[0]}" if len(tree) == 2 else f"{parts[0]}{tree[1]}{parts[1]}"


def goes_to(expression, language):
    """X [mm] at the end of the program of an expression."""
    return read_text(WRITTEN[language][0].format(expression), None, controller=language).tip[-1, 0] * 1e3


@settings(max_examples=40, deadline=None)
@given(tree=trees(4))
def test_every_language_comes_to_what_python_does(tree):
    try:
        wanted = value(tree)
    except (ZeroDivisionError, ValueError):
        assume(False)
    assume(1e-2 < abs(wanted) < 1e3)
    for language in WRITTEN:
        # Fanuc rounds the value of an axis word to its least increment
        assert goes_to(written(tree, language), language) == pytest.approx(wanted, rel=1e-9, abs=0.5001e-3)


@pytest.mark.parametrize("language", WRITTEN)
def test_operators_bind_alike(language):
    assert goes_to("2+3*4-6/2/3-1", language) == pytest.approx(12.0)


@pytest.mark.parametrize(("language", "most"), [("fanuc", 500), ("sinumerik", 500), ("heidenhain", 200)])
def test_a_long_sum_is_read_and_a_longer_one_refused(language, most):
    """Values of long sums are worked out from within: without a limit Python's own stack would end them."""
    variable = {"fanuc": "#2", "sinumerik": "R2", "heidenhain": "Q2"}[language]
    template = WRITTEN[language][0].replace("\n", f"\n{variable}=0.01\n", 1)

    def end(operators):
        text = template.format("+".join([variable] * (operators + 1)))
        return read_text(text, None, controller=language).tip[-1, 0] * 1e3

    assert end(most) == pytest.approx(0.01 * (most + 1), abs=0.5001e-3)
    with pytest.raises(ProgramError, match=f"more than {most} operators"):
        end(most + 1)


@pytest.mark.parametrize(("language", "most"), [("fanuc", 60), ("linuxcnc", 60), ("sinumerik", 40), ("heidenhain", 60)])
def test_brackets_count_alike_before_and_behind_an_operator(language, most):
    _, opening, closing, _ = WRITTEN[language]
    free = most - 1 - (language == "linuxcnc")  # the value within is one level, and LinuxCNC's sums stand in brackets
    for form in ("1+{}", "{}+1"):
        nested = "1"
        for _ in range(free):
            nested = form.format(f"{opening}{nested}{closing}")
        assert goes_to(nested, language) == pytest.approx(free + 1)
        with pytest.raises(ProgramError, match=f"more than {most} brackets"):
            goes_to(form.format(f"{opening}{nested}{closing}"), language)


@pytest.mark.parametrize("language", WRITTEN)
@pytest.mark.parametrize(
    ("expression", "said"),
    [("1/0", "division by zero"), ("SQRT{0}0-1{1}", "SQRT of -1 is no number"), ("1+", "a value is missing before")],
)
def test_errors_are_the_same_in_every_language(language, expression, said):
    _, opening, closing, _ = WRITTEN[language]
    with pytest.raises(ProgramError, match=said):
        goes_to(expression.format(opening, closing), language)


def test_labels_are_found_below_and_above():
    labels = Labels()
    for index in (3, 7, 9):
        labels.add("A", index)
    assert [labels.below("A", index) for index in (2, 3, 8, 9)] == [3, 7, 9, None]
    assert [labels.above("A", index) for index in (2, 3, 8, 9)] == [None, 3, 7, 9]
    assert labels.below("B", 0) is None and labels.above("B", 9) is None


def test_branches_and_ends_belong_to_the_innermost_of_their_name():
    nesting = Nesting()
    nesting.begin("IF", 0, "1")
    nesting.begin("WHILE", 1, "2")
    nesting.branch(2, "1")
    assert nesting.close(4, "1") == 0
    assert nesting.innermost("1") is None and nesting.innermost("2").parts == [1]
    assert nesting.following == {0: 2, 2: 4} and nesting.end == {2: 4} and nesting.partner == {0: 4, 4: 0}


def test_a_frame_is_repeated_and_gives_back_what_its_caller_had():
    given_back = []
    stack = CallStack(Frame(kind=MAIN), {CALL: (2, " (alarm 1)"), "": (3, "")})
    stack.enter(Frame(begin=5, next=8, again=1, at_return=[lambda: given_back.append("modes")]), "A")
    assert stack.leave() is None and stack[-1].next == 5 and not given_back
    assert stack.leave() is not None and given_back == ["modes"] and len(stack) == 1


def test_levels_are_counted_by_kind_and_together():
    stack = CallStack(Frame(kind=MAIN), {CALL: (2, " (alarm 1)"), "": (3, "")})
    stack.enter(Frame(), "A")
    stack.enter(Frame(), "B")
    with pytest.raises(BlockError, match=r"more than 2 deep \(alarm 1\): does C call itself"):
        stack.enter(Frame(), "C")
    stack.enter(Frame(kind=PART), "C")
    with pytest.raises(BlockError, match="more than 3 deep: does D call itself"):
        stack.enter(Frame(kind=PART), "D")


@pytest.mark.parametrize("value", [0, 11, 2.5, math.nan])
def test_a_number_of_times_is_whole_and_within_its_limits(value):
    assert times(10, "L", 10) == 10
    with pytest.raises(BlockError, match="write a whole number from 1 to 10"):
        times(value, "L", 10)
