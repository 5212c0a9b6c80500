"""O-words within each other: what runs, and where LinuxCNC's interpreter does not do what its manual says."""

from __future__ import annotations

import pytest

from testbed.against_rs274 import surprise
from testbed.linuxcnc.nested import nested_job
from testbed.linuxcnc.rs274 import available
from tests.support.controllers import tips
from toolpace.common.errors import ProgramError

START = "G90 G21 G94 G17 F100\nG0 X0 Y0 Z0\n"
WHILE = "#1=0\no1 while [#1 lt 3]\n#1=[#1+1]\n{}\no1 endwhile\n"
DO = "#2=0\no2 do\n#2=[#2+1]\nG1 X[10*#2]\no2 while [#2 lt 3]\n"
REPEAT = "o3 repeat [2]\n#3=[#3+1]\nG1 Y#3\n{}\no3 endrepeat\n"


def places(body: str) -> list[list[float]]:
    """X and Y of the points behind the first [mm]."""
    return [[round(x, 6) for x in row[:2]] for row in tips("linuxcnc", f"{START}{body}M2\n")[1:]]


@pytest.mark.parametrize(("first", "wanted"), [("eq", [[1, 0], [12, 0], [13, 0]]), ("ne", [[11, 0], [2, 0], [3, 0]])])
def test_each_round_runs_one_branch(first, wanted):
    """A branch that one round took is not taken beside another in the next."""
    assert places(WHILE.format(f"o4 if [#1 {first} 1]\nG1 X#1\no4 else\nG1 X[10+#1]\no4 endif")) == wanted


def test_branches_of_else_if_in_rounds():
    body = "o4 if [#1 eq 3]\nG1 X3\no4 elseif [#1 eq 2]\nG1 X2\no4 else\nG1 X1\no4 endif"
    assert places(WHILE.format(body)) == [[1, 0], [2, 0], [3, 0]]


def test_a_loop_that_is_left_and_no_other_behind_it():
    assert places(DO + WHILE.format("G1 X#1\no1 break") + "G1 X7\n") == [[10, 0], [20, 0], [30, 0], [1, 0], [7, 0]]


@pytest.mark.parametrize(
    ("body", "what"),
    [
        (WHILE.format("o1 break") + DO, "do loop ends after one round, for the break in line 6"),
        # passed over on the way to the end, in each of three manners
        (WHILE.format("o4 if [0]\no1 break\no4 endif") + DO, "do loop ends after one round, for the break in line 7"),
        (WHILE.format("o1 continue\no1 break").replace("lt 3", "lt 1") + DO, "do loop ends .* break in line 7"),
        ("o2 do\no4 if [#2 lt 2]\n#2=[#2+1]\nG1 X#2\no2 continue\no4 endif\no2 break\no2 while [1]\n", "do loop ends"),
        (DO.replace("G1", "o2 continue\nG1") + REPEAT.format(""), "repeat begins again, for the continue in line 6"),
        (DO.replace("G1", "o2 continue\nG1") + WHILE.format("G1 X#1\no1 break"), "break goes round again"),
        (WHILE.format(REPEAT.format("o1 continue")), "rounds that were left"),
        ("o5 sub\n" + REPEAT.format("o5 return") + "o5 endsub\no5 call\no5 call\n", "rounds that were left"),
        (REPEAT.format("o3 break"), "a break of a repeat loop"),
        (REPEAT.format("o3 continue").replace("[2]", "[0]"), "a continue of a repeat loop"),
    ],
)  # fmt: skip
def test_where_its_interpreter_takes_one_loop_for_another(body, what):
    with pytest.raises(ProgramError, match=what):
        places(body)


@pytest.mark.linuxcnc
@pytest.mark.skipif(available() is None, reason="LinuxCNC's interpreter rs274 is not installed")
class TestRandom:
    @pytest.mark.sweep
    def test_forty(self):
        assert not [found for found in (surprise(nested_job(seed)) for seed in range(40)) if found]

    @pytest.mark.thorough
    def test_two_thousand(self):
        assert not [found for found in (surprise(nested_job(seed)) for seed in range(100, 2100)) if found]
