"""A program that may be for several controls: what they would read differently is said, with both meanings."""

from __future__ import annotations

from collections import Counter

import msgspec
import pytest

import toolpace as tp
from testbed.recognised import OUTCOMES, RANDOM, main, random_outcomes
from toolpace.common.errors import UsageError
from toolpace.programs.reading import Findings, ReadOptions, Source, read_commanded, read_source, read_text
from toolpace.programs.reading.controllers.recognise import thinned
from toolpace.programs.reading.inspection import inspect_source
from toolpace.programs.reading.languages import with_controller
from toolpace.results.write.result import read_again, reading_record, write_reading_options

HEAD = "G21 G90 G0 X0 Y0 Z5\nG1 X10 F600\n"
CURE = "--controller"


def said(text: str, **given) -> list[str]:
    return [sentence for sentence in read_text(text, **given).assumed if CURE in sentence]


def test_a_dwell_that_is_seconds_or_milliseconds_is_said_with_its_block():
    (sentence,) = said(HEAD + "\nG4 P500\nG1 X20\n")
    assert sentence.startswith("line 4 'G4 P500' waits 500 s, as for iso; for fanuc and haas it waits 0.5 s:")


def test_an_offset_that_adds_or_not_is_said_where_the_tool_goes_elsewhere():
    text = "O1234\nG21 G90 G54 G0 X0 Y0 Z5\nG10 L2 P1 X5\nG91 G10 L2 P1 X1\nG90 G1 X5 F600\n"
    (sentence,) = said(text)
    assert sentence == read_text(text).assumed[0]
    assert sentence.startswith("line 5 'G90 G1 X5 F600' goes to X6 Y0 Z5 mm of the part at 600 mm/min, as for fanuc")
    assert "for linuxcnc it goes to X1 Y0 Z5 mm" in sentence


def test_a_feed_before_its_unit_is_said():
    (sentence,) = said("G0 X0 Y0 Z0\nG20 F60\nG1 X1\n")
    assert "X25.4 Y0 Z0 mm of the part at 1524 mm/min, as for iso; for linuxcnc" in sentence
    assert "at 60 mm/min" in sentence


@pytest.mark.parametrize(
    "text", [HEAD + "G2 X20 Y0 I5 J0\nG4 X1.5\nG1 Z0\nM30\n", "%_N_A_MPF\nG71 G90 G0 X0 Y0 Z5\nG1 X10 F600\nG4 F2\n"]
)
def test_nothing_is_said_where_all_read_alike(text):
    assert not said(text)


def test_a_doubt_amid_many_plain_motions_is_said_with_its_own_figures():
    ways = "".join(f"N{n} G1 X{n}. Y1.5\n" for n in range(1, 200))
    (sentence,) = said(f"O1234\nG21 G90 G54 G0 X0 Y0 Z5\nG10 L2 P1 X5\nF600\n{ways}G91 G10 L2 P1 X1\nG90\n{ways}")
    assert sentence.startswith("line 206 'N1 G1 X1. Y1.5' goes to X2 Y1.5 Z5 mm of the part at 600 mm/min, as for fa")
    assert "for linuxcnc it goes to X-3 Y1.5 Z5 mm" in sentence


def test_most_plain_motions_are_read_once():
    """So that a program which may be for four controls is not read four times."""
    ways = [f"N{n}G1X{n}.Y1.5F600" for n in range(100)]
    arcs = ["G2 X1. Y2. I.5 J.5"] * 9
    short = thinned(Source.from_text("\n".join(["G21 G90 G0 X0 Y0 Z5", *ways, "G4 P2", *ways, *arcs, "X1", "G0 X2"])))
    assert [n for n, line in enumerate(short.lines, 1) if line] == [
        1, 2, 3, 4, 102, 103, 104, 105, *range(203, 214),
    ]  # fmt: skip
    jumping = thinned(Source.from_text("\n".join([*ways, "GOTO 50"])))
    assert jumping.lines[50] == "N50"


@pytest.mark.parametrize("given", [{"controller": "fanuc"}, {"name": "part.ngc"}])
def test_nothing_is_said_where_the_control_is_known(given):
    assert not said(HEAD + "G4 P2\nG1 X20\nM2\n", **given)


def test_a_control_that_refuses_the_program_is_no_candidate():
    assert "linuxcnc" in said("O1234\n" + HEAD + "G4 P2\nG1 X20\n")[0]
    # G68 is refused for LinuxCNC
    assert not said("O1234\n" + HEAD + "G68 X0 Y0 R10\nG1 X20 Y0\nG4 P2\nG69\n")


def test_what_is_passed_over_does_not_hide_a_doubt():
    text = "O1234\n" + HEAD + "G31 Z-5\nG4 P2\nG1 X20\n"
    assert any("'G4 P2'" in sentence for sentence in said(text, skip_unknown=True))


def test_inspecting_and_timing_say_it_too():
    source = Source.from_text(HEAD + "G4 P500\nG1 X20\nG31 Z-5\n", "part.nc")
    found = inspect_source(source, ReadOptions(), [tp.Machine.load("xyzac-trunnion"), tp.Machine.load("xyzbc-table")])
    assert any("'G4 P500'" in sentence for sentence in found.assumed)
    assert len(found.refused) == 1
    findings = Findings()
    read_commanded(Source.from_text(HEAD + "G4 P500\nG1 X20\n"), findings=findings)
    assert any("'G4 P500'" in sentence for sentence in findings.assumptions)


def test_a_plan_is_read_again_with_the_doubt_that_it_was_made_with(tmp_path):
    source = Source.from_text(HEAD + "G4 P500\nG1 X20\n")
    options, _ = with_controller(source, None, ReadOptions())
    write_reading_options(tmp_path, options)
    again = read_again(tmp_path, reading_record(options))
    assert read_source(source, None, None, again).assumed == read_source(source).assumed != ()
    with pytest.raises(UsageError, match="others of reading names 'okuma'"):
        read_again(tmp_path, msgspec.structs.replace(reading_record(options), others=("okuma",)))


@pytest.mark.parametrize("dialect", ["haas", "linuxcnc"])
def test_random_programs_do_not_move_otherwise_unsaid(dialect):
    """Programs without a name or a header are read as for their true control, or refused, or the difference is said."""
    came = Counter(outcome for _, _, outcome in random_outcomes(dialect, range(14, 32)))
    assert came["unsaid"] == 0
    assert came["said"] > 1
    assert came["right"] > 1


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(1000, 1040), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(1040, 1100), marks=pytest.mark.thorough, id="many"),
    ],
)
@pytest.mark.parametrize("dialect", RANDOM)
def test_many_random_programs_do_not_move_otherwise_unsaid(dialect, seeds):
    assert "unsaid" not in {outcome for _, _, outcome in random_outcomes(dialect, seeds)}


def test_the_table_of_confusions_counts_each_program_once(tmp_path, capsys):
    folder = tmp_path / "linuxcnc"
    folder.mkdir()
    (folder / "a.ngc").write_text(HEAD)
    (folder / "b.nc").write_text(HEAD)
    (folder / "c.nc").write_text("G0 X0 Y0 Z0\nG20 F60\nG1 X1\n")
    (folder / "d.nc").write_bytes(b"\0\1\2")
    assert main([str(folder)]) == 0
    table = [line.split("|")[1:-1] for line in capsys.readouterr().out.splitlines()[2:]]
    counts = {row[1].strip(): [int(figure.strip() or 0) for figure in row[2:]] for row in table}
    assert counts["linuxcnc"] == [1] + [0] * len(OUTCOMES)
    assert counts["iso"] == [2, 1, 0, 1, 0, 0, 0]
