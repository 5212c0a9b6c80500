"""What LinuxCNC's interpreter stops at is refused, what it runs is read; `lenient` reads on where that is certain."""

from __future__ import annotations

import pytest

from testbed.against_rs274 import difference
from testbed.linuxcnc.job import Job
from testbed.linuxcnc.rs274 import available
from tests.support.controllers import read_for
from toolpace.common.errors import ProgramError
from toolpace.programs.reading import read_text

HEAD = "G21 G90 G94 G17 F600\nG0 X10 Y0 Z5\n"
TOOLS = {1: 80.0, 2: 100.0}
BODIES = "o2 if [#1 LT 10]\no1 call [#1+1]\no2 endif"
STOPS = {
    "F0 and a feed motion": "F0\nG1 X3",
    "R of G61": "G61 R1",
    "R of G64": "G64 P1 R1",
    "a subprogram within another": "o1 sub\no2 sub\no2 endsub\no1 endsub",
    "a subprogram in a loop": "o1 repeat [2]\no2 sub\no2 endsub\no1 endrepeat",
    "a subprogram twice": "o1 sub\no1 endsub\no1 sub\no1 endsub",
    "a label of two conditions": "o1 if [1]\no1 endif\no1 if [1]\no1 endif",
    "a label of two loops": "o1 while [0]\no1 endwhile\no1 while [0]\no1 endwhile",
    "calls ten deep": f"o1 sub\n{BODIES}\nG91 G0 X1\no1 endsub\no1 call [1]",
    "31 arguments": "o1 sub\no1 endsub\no1 call" + " [1]" * 31,
    "if without a bracket": "o1 if #1\no1 endif",
    "repeat without a bracket": "o1 repeat 2\no1 endrepeat",
    "call without a bracket": "o1 sub\no1 endsub\no1 call 2",
    "words behind a call": "o1 sub\no1 endsub\no1 call [2] G0 X3",
    "a value behind endif": "o1 if [1]\no1 endif [2]",
    "G84 at rest": "G84 X1 Y1 Z-1 R1",
    "G84 after M4": "M4 S9\nG84 X1 Y1 Z-1 R1",
    "G74 after M3": "M3 S9\nG74 X1 Y1 Z-1 R1",
    "G84 behind a tool change": "M3 S9\nT1 M6\nG84 X1 Y1 Z-1 R1",
    "G86 at rest": "G86 X1 Y1 Z-1 R1 P0",
    "P below zero": "G82 X1 Y1 Z-1 R1 P-1",
    "K of G81": "G81 X1 Y1 Z-1 R1 K3",
    "R alone in a cycle": "G81 X1 Y1 Z-1 R1\nR2",
    "G28 with G1": "G28 G1 X5",
    "P of G30": "G30 P3",
    "G53 alone": "G53",
    "G2 alone": "G2",
    "H of no whole number": "G43 H1.5",
    "H below zero": "G43 H-1",
    "I of G43.1": "G43.1 I1",
    "a word twice": "G17 G17",
    "two of one group": "M7 M8",
    "ATAN of one value": "G0 X[ATAN[1]]",
    "a sum without brackets": "#1=4+5",
    "a read-only number": "#5420=3",
    "a read-only name": "#<_x>=3",
    "a number too high": "#5602=3",
    "a comment within a word": "G0 X(hi)3",
    "a comment within a number": "G0 X1(hi)2",
    "N twice": "N1 N2 G0 X3",
    "N in the middle": "G0 N2 X3",
    "/ in the middle": "G0 X3 /Y3",
    "/ behind N": "N5 /G0 X3",
    "a long line": "G0 X3" + " " * 250 + "Y2",
    "R beside I": "G2 X0 Y10 R10 I0",
    "radii far apart": "G0 X3000\nG2 X-3002.84 Y0 I-3000 J0",
    "M62 without P": "M62",
    "G96 without S": "G96",
    "D of G1": "G1 X3 D3",
    "E as an exponent": "G1 X3E1",
    "two inputs": "M66 P0 E0 L0",
}
RUNS = {
    "F0 where nothing feeds": "F0\nG0 X3",
    "else if with a blank": "o1 if [1 GT 2]\nG1 X2\no1 else if [1 EQ 1]\nG1 X3\no1 end if",
    "end sub with a blank": "o1 sub\nG1 X3\no1 end sub\no1 call",
    "blanks within": "o1 w h i l e [0]\nG0 X3\no1 e n d w h i l e",
    "a call that is reckoned": "o20 sub\nG0 X1\no20 endsub\n#2=2\no[#2*10] call",
    "rounds up": "o1 repeat [2.7]\nG91 G0 X1\no1 endrepeat",
    "half a round": "o1 repeat [2.5]\nG91 G0 X1\no1 endrepeat",
    "calls nine deep": f"o1 sub\n{BODIES.replace('10', '9')}\nG91 G0 X1\no1 endsub\no1 call [1]",
    "one label in two subprograms": "o1 sub\no2 if [1]\no2 endif\no1 endsub\no2 if [1]\nG0 X2\no2 endif\no1 call",
    "30 arguments": "o1 sub\nG1 X#30\no1 endsub\no1 call" + " [1]" * 30,
    "M66 with a motion": "M66 P0 L3 Q1 G1 X3",
    "M19 with a motion": "M19 R10 G1 X3",
    "G next to a whole number": "G1.00001 X3",
    "P of an arc next to one": "G2 X10 Y0 I-10 J0 P1.00001",
    "P and L of G10 next to one": "G10 L2.00001 P1.00001 X3\nG0 X3",
    "what M66 found is set": "#5399=1\nG0 X#5399",
    "the tangent of 90 degrees": "#1=TAN[90]\nG0 X[#1/10000000000000000000] Y[[COS[90] LT 0]+2*[ACOS[.5] GT 60]]",
    "no blank behind an operation": "#1=3\nG0 X[2LTABS[#1]] Y[7MODFIX[2.5]]",
    "N by parts": "N4.5 G0 Y3",
    "EXISTS beyond the last": "G0 X[EXISTS[#5602]+EXISTS[#5601]]",
    "a spiral": "G2 X-10.02 Y0 I-10 J0",
    "a spiral in inch": "G20 F20\nG0 X1 Y0\nG2 X-1.0028 Y0 I-1 J0",
    "G86 while it turns": "M4 S9\nG86 X1 Y1 Z-1 R1 P0",
}


@pytest.mark.linuxcnc
@pytest.mark.skipif(available() is None, reason="LinuxCNC's interpreter rs274 is not installed")
@pytest.mark.parametrize("name", [*STOPS, *RUNS])
def test_it_stops_where_the_interpreter_stops_and_runs_where_it_runs(name):
    found = difference(Job(HEAD + (STOPS | RUNS)[name] + "\nM2\n", tools=TOOLS, numbered=False))
    assert found == ""


@pytest.mark.parametrize("name", [name for name in STOPS if name != "F0 and a feed motion"])
def test_what_it_stops_at_is_refused_in_one_line_with_its_place(name):
    with pytest.raises(ProgramError, match=r"^part\.nc[:(].*:") as caught:
        read_for("linuxcnc", HEAD + STOPS[name] + "\nG1 X7\nM2\n")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("body", RUNS.values(), ids=RUNS)
def test_what_it_runs_is_read(body):
    assert len(read_for("linuxcnc", HEAD + body + "\nG1 X7 F9\nM2\n")) > 1


CERTAIN = {
    "G17 G17 G0 X1\nM2\n": "G17 twice in a block (first line 3, 1 time)",
    "M7 M8\nG0 X1\nM2\n": "M7 and M8 in one block",
    "G0 X1 D3\nM2\n": "D without a word that uses it",
    "G61 R1 \nG0 X1\nM2\n": "R without a word that uses it",
    "N1 N2 G0 X1\nM2\n": "N in the middle of a block",
    "M3 S9\nG74 X1 Y1 Z1 R2\nM2\n": "G74 while the spindle turns by M3",
    "G0 X1\n": "the end without M2, M30 or %",
    "G0 X1\n%\n": "% that ends what none begins",
}


@pytest.mark.parametrize("body", CERTAIN)
def test_lenient_reads_on_and_lists_it(body):
    with pytest.raises(ProgramError, match=r"stops the control: .*--lenient reads on"):
        read_text(HEAD + body, controller="linuxcnc")
    path = read_text(HEAD + body, controller="linuxcnc", lenient=True)
    assert path.tip[-1, 0] == pytest.approx(1e-3)
    assert any("read, though the control stops there:" in said and CERTAIN[body] in said for said in path.assumed)


@pytest.mark.parametrize("name", ["K of G81", "P of G30", "G28 with G1", "E as an exponent", "a sum without brackets"])
def test_lenient_does_not_read_what_may_mean_another_thing(name):
    with pytest.raises(ProgramError):
        read_text(HEAD + STOPS[name] + "\nM2\n", controller="linuxcnc", lenient=True)


def test_several_are_listed_together_with_what_is_not_read():
    with pytest.raises(ProgramError) as caught:
        read_text(HEAD + "G17 G17\nG7\nG0 X1\n", controller="linuxcnc")
    assert str(caught.value).startswith("program: 3 things stop the control, or are not read: G17 twice")
    with pytest.raises(ProgramError, match="G7 is not read"):
        read_text(HEAD + "G17 G17\nG7\nG0 X1\n", controller="linuxcnc", lenient=True)


def test_other_controls_run_what_linuxcnc_stops_at():
    text = HEAD + "G17 G17 M8 M8\nG0 N2 X3 /Y4\nM30\n"
    assert read_for("fanuc", text).tip[-1, 0] == pytest.approx(3e-3)


@pytest.mark.parametrize(
    ("name", "where"),
    [("_hal[spindle.0.speed-in]", "HAL of the machine"), ("_ini[TOOLS]change_x", "the INI file of the machine")],
)
def test_values_of_hal_and_of_the_ini_file_come_from_the_set_up_sheet(tmp_path, name, where):
    text = f"{HEAD}G0 X#<{name}>\nM2\n"
    with pytest.raises(ProgramError, match=where + r" has it, .*give it in \[variables\]"):
        read_text(text, controller="linuxcnc")
    sheet = tmp_path / "sheet.toml"
    sheet.write_text(f'[variables]\n"{name}" = 2.5\n')
    assert read_text(text, controller="linuxcnc", setup=sheet).tip[-1, 0] == pytest.approx(2.5e-3)


def test_text_before_the_first_percent_is_part_of_the_program():
    """To LinuxCNC only a % in the first line begins one: what stands before is not passed over."""
    with pytest.raises(ProgramError, match="TEXT"):
        read_text("text before\n%\nG21 G0 X1 Y1 Z1\nX2\n%\n", controller="linuxcnc")
    assert len(read_text("\n%\nG21 G0 X1 Y1 Z1\nX2\n%\n", controller="linuxcnc")) == 2


def test_a_subprogram_behind_the_closing_percent_is_not_there():
    with pytest.raises(ProgramError, match="O2 is called, and is not in this file"):
        read_text("%\nG21 G0 X1 Y1 Z1\no2 call\n%\no2 sub\nG0 X2\no2 endsub\n", controller="linuxcnc")
