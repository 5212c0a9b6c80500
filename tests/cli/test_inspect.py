"""`toolpace inspect`: what programs are and need, in JSON as a contract and on a page as a machinist reads it."""

from __future__ import annotations

import json
import re

import pytest

from toolpace.cli import demo_programs, main
from toolpace.machine.machine import Machine
from toolpace.programs.reading.setup_file import load_setup

CONTRACT = {"program", "dialect", "blocks", "five_axis_blocks", "refused", "ignored", "assumed", "machines"}
FIVE = """\
G21 G90 G94
G43.4 H1
G0 X0 Y0 Z50 A0 C0
G1 Z1 F600
X10 A10
X20 A20 C30
C30
G2 X30 Y0 I5 J0
G0 Z50
M30
"""
CLSF = """\
TOOL PATH/ROUGH,TOOL,D10
GOTO/0,0,10,0,0,1
FEDRAT/500,MMPM
GOTO/10,0,10
GOTO/10,10,10,0,0.6,0.8
WOBBLE/3
WOBBLE/4
SPIRAL/1
END-OF-PATH
"""


@pytest.fixture
def five(tmp_path):
    path = tmp_path / "five.ngc"
    path.write_text(FIVE)
    return str(path)


def inspected(capsys, *arguments):
    capsys.readouterr()
    code = main(["inspect", *arguments, "--json"])
    said = capsys.readouterr()
    assert said.err == ""
    return code, json.loads(said.out)


def test_json_keeps_the_contract(five, capsys):
    code, (found,) = inspected(capsys, five)
    assert code == 0 and set(found) >= CONTRACT
    assert found["program"] == five and found["refused"] == []
    assert found["blocks"] == 10 and found["five_axis_blocks"] == 2 and found["arcs"] == 1 and found["rapids"] == 1
    assert found["dialect"] in ("linuxcnc", "iso", "fanuc", "haas") and found["reason"]
    assert found["tip_mm"][0] == pytest.approx([0, 30], abs=1e-6) and found["tip_mm"][2] == [1, 50]
    assert found["tilt_deg"] == pytest.approx([0, 20], abs=1e-9)
    assert found["rotary_deg"] == {"C": pytest.approx([0, 30]), "A": pytest.approx([0, 20])}


def test_machines_that_can_run_it_and_why_others_cannot(five, capsys):
    _, (found,) = inspected(capsys, five)
    assert "xyzac-trunnion" in found["machines"] and found["read_on"] in found["machines"]
    assert set(found["machines"]) | set(found["not_on"]) == set(Machine.names())
    assert found["not_on"]["xyzbc-head"] == "line 3: it has no axis A"
    assert found["not_on"]["paper-ab"] == "line 3: it has no axis C"


def test_travel_keeps_machines_from_running_it(tmp_path, capsys):
    path = tmp_path / "far.ngc"
    path.write_text("G0 X0 Y0 Z0\nG1 X600 F1000\nM30\n")
    _, (found,) = inspected(capsys, str(path))
    assert "xyzac-trunnion" not in found["machines"] and "xyzbc-head" in found["machines"]
    assert "600.000 mm, above its limit of 500 mm" in found["not_on"]["xyzac-trunnion"]
    assert "\n" not in found["not_on"]["xyzac-trunnion"]


POLE = """\
G21 G90 G94
G43.4 H1
G0 X0 Y0 Z0 B0.03 C0
G1 X10 F1000
X10.5 C-359.9
X20
M30
"""
"""Beside its pole C turns by nearly a turn and stands: a smooth path swings beyond, and the axis hardly feels it."""

MOST_SWING = 30.0
"""Beyond the end of travel [deg]: the smoothest path swings 15.6 beyond it."""


def swings_beyond(said: str) -> bool:
    """Whether it says that C goes beyond its travel, by a swing: no program asks for more than -359.9 deg."""
    found = re.search(r"joint C would have to go to (\S+) deg, below its limit of -360 deg;?", said)
    return found is not None and -360.0 - MOST_SWING < float(found[1]) < -360.0


def test_a_machine_is_named_only_where_the_smooth_path_stays_in_travel_too(tmp_path, capsys):
    path = tmp_path / "pole.nc"
    path.write_text(POLE)
    as_fanuc = [str(path), "--controller", "fanuc", "--machine", "xyzbc-head"]
    _, (found,) = inspected(capsys, *as_fanuc)
    assert found["machines"] == []
    assert found["not_on"]["xyzbc-head"].startswith("line 6: ") and swings_beyond(found["not_on"]["xyzbc-head"])
    # and that is what a plan says, before it plans
    assert main(["plan", *as_fanuc, "--out", str(tmp_path / "plan")]) == 2
    said = capsys.readouterr()
    assert "pole.nc:6: joint C" in said.err and swings_beyond(said.err) and "planning" not in said.out
    path.write_text(POLE.replace("C-359.9", "C-300"))
    _, (found,) = inspected(capsys, *as_fanuc)
    assert found["machines"] == ["xyzbc-head"], "the points themselves are far from the end"


def test_only_what_is_close_to_the_ends_of_travel_is_fitted(tmp_path, capsys, monkeypatch):
    from toolpace.path.path import Path

    fitted = []
    fit = Path.fit
    monkeypatch.setattr(Path, "fit", lambda toolpath, *given: fitted.append(len(toolpath)) or fit(toolpath, *given))
    path = tmp_path / "long.nc"
    path.write_text("G21 G90\nG0 X0 Y0 Z0\n" + "".join(f"G1 X{x / 10} F900\n" for x in range(4990)))
    _, (found,) = inspected(capsys, str(path), "--machine", "xyzac-trunnion")
    assert found["machines"] == ["xyzac-trunnion"]
    assert 0 < sum(fitted) < 300


def test_a_cure_stands_once_on_the_page(tmp_path, capsys):
    path = tmp_path / "inches.nc"
    path.write_text("G20 G90 G94\nG0 X0 Y0 Z0\nG1 X400 F100\nM30\n")
    assert main(["inspect", str(path)]) == 0
    page = " ".join(capsys.readouterr().out.split())
    assert page.count("see whether the program is in the unit that it says (inches, mm)") == 1
    assert "the program uses 10160 mm of X, which has 1000 mm" in page


def test_all_refused_words_are_told_with_first_line_count_and_cure(tmp_path, capsys):
    path = tmp_path / "part.cls"
    path.write_text(CLSF)
    code, (found,) = inspected(capsys, str(path))
    assert code == 2
    told = {each["word"]: (each["line"], each["count"]) for each in found["refused"]}
    assert told == {"WOBBLE": (6, 2), "SPIRAL": (8, 1)} and all(each["cure"] for each in found["refused"])
    # what is read is told all the same
    assert found["five_axis_blocks"] == 1 and found["tools"] == ["D10"] and found["tip_mm"][0] == [0, 10]
    assert not any("skipped" in sentence for sentence in found["assumed"])
    code, (found,) = inspected(capsys, str(path), "--skip-unknown")
    assert code == 0 and found["refused"] == []
    assert any("skipped WOBBLE (first line 6, 2 times)" in sentence for sentence in found["assumed"])


def test_what_cannot_be_read_is_told_and_stops_no_other(five, tmp_path, capsys):
    binary, prose, wrong = (tmp_path / name for name in ("a.bin", "b.txt", "c.ngc"))
    binary.write_bytes(b"\x7fELF\0\0\0")
    prose.write_text("hello world\n")
    wrong.write_text("G0 X0 Y0 Z0\nG1 X10 F100\nG1 X1..5\nM30\n")
    names = [str(tmp_path / "gone.ngc"), str(binary), str(prose), str(wrong), five]
    code, found = inspected(capsys, *names)
    assert code == 2 and [each["program"] for each in found] == names
    words = ["no such file", "binary", "recognised", "", None]
    for each, word in zip(found, words):
        if word is None:
            assert each["refused"] == [] and each["machines"]
        else:
            (refusal,) = each["refused"]
            assert word in refusal["cure"] and refusal["count"] == 1 and each["machines"] == []
    assert found[3]["refused"][0]["line"] == 3 and "X1..5" in found[3]["refused"][0]["word"]
    assert found[3]["not_on"]["xyzac-trunnion"] == "the program is not read whole: see what is refused"


def test_a_page_of_one_program_and_a_table_of_many(five, tmp_path, capsys):
    assert main(["inspect", five]) == 0
    page = capsys.readouterr().out
    for words in (
        "dialect",
        "10, of them 2 turn the tool",
        "refused",
        "nothing: every word is read",
        "runs on",
        "not on",
    ):
        assert words in page
    other = tmp_path / "part.cls"
    other.write_text(CLSF)
    assert main(["inspect", five, str(other)]) == 2
    table = capsys.readouterr().out
    assert "five.ngc" in table and "part.cls" in table and "WOBBLE (first line 6, 2 times)" in table


def test_a_table_breaks_no_name_and_says_where_a_program_is_not_read_whole(five, tmp_path, capsys):
    other = tmp_path / "a-program-with-rather-a-long-name.cls"
    other.write_text("GOTO/0,0,0,0,0,1\nGOTO/1,0\n")
    assert main(["inspect", five, str(other)]) == 2
    lines = [line for line in capsys.readouterr().out.splitlines() if f"{other.name}:" not in line]
    (row,) = [line for line in lines if other.name in line]
    assert "not read" in row and "none" not in row


def test_a_table_says_where_to_look_when_no_machine_can_run_a_program(five, tmp_path, capsys):
    far = tmp_path / "far.ngc"
    far.write_text("G0 X0 Y0 Z0\nG1 X90000 F1000\nM30\n")
    assert main(["inspect", five, str(far)]) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "inspect it alone" in line]
    assert [line.partition(":")[0] for line in told] == ["far.ngc"]


def test_a_sheet_is_proposed_where_stand_ins_of_machine_zero_lead_out_of_travel(tmp_path, capsys):
    path = tmp_path / "zero.ngc"
    path.write_text("G53 G0 X0 Y0 Z0\nG10 L20 P0 X0 Y0 Z0\nG1 X20 F500\nM2\n")
    assert main(["inspect", str(path), "--controller", "linuxcnc"]) == 0
    assert "say on a set-up sheet where machine zero and reference points are" in " ".join(
        capsys.readouterr().out.split()
    )
    path.write_text("G0 X0 Y0 Z0\nG1 X900 F500\nM2\n")
    assert main(["inspect", str(path), "--controller", "linuxcnc"]) == 0
    assert "set-up sheet" not in capsys.readouterr().out


def test_a_plan_is_refused_with_the_cure_that_inspect_tells(tmp_path, capsys):
    """An offset of 5 m below a machine zero that the sheet does not tell: 4101 mm below, where Z ends at -800."""
    path, sheet = tmp_path / "far.nc", tmp_path / "setup.toml"
    path.write_text("G21 G90 G94\nG54\nG0 X0. Y0. Z50.\nG1 Z0. F500\nX50.\nM30\n")
    text = '[units]\nlength = "mm"\n[offsets.G54]\nX = -100\nY = -100\nZ = -5000\n'
    sheet.write_text(text)
    cure = (
        "say on a set-up sheet where machine zero and reference points are ([machine_zero]): inspect --write-setup "
        "FILE writes one to fill in"
    )
    of_machine = ["--controller", "fanuc", "-m", "xyzbc-head", "--setup", str(sheet)]
    assert main(["inspect", str(path), *of_machine]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert cure in told and "does not say where machine zero is" in told
    for command in (["plan", str(path), "-o", str(tmp_path / "out")], ["tolerance", str(path)], ["time", str(path)]):
        assert main([*command, *of_machine]) == 2
        assert cure in " ".join("".join(capsys.readouterr()).split()), command
    sheet.write_text(text + "[machine_zero]\nX = 0\nY = 0\nZ = 0\n")
    assert main(["plan", str(path), "-o", str(tmp_path / "out"), *of_machine]) == 2
    assert "set-up sheet" not in capsys.readouterr().err


def test_the_demo_is_read_whole(tmp_path, capsys):
    path = tmp_path / "impeller.ngc"
    path.write_text(demo_programs.impeller_program(Machine.load(demo_programs.MACHINE)))
    code, (found,) = inspected(capsys, str(path))
    assert code == 0 and demo_programs.MACHINE in found["machines"]
    assert found["five_axis_blocks"] > 0.9 * found["blocks"]


def test_a_sheet_to_fill_in_is_written_once(five, tmp_path, capsys):
    sheet = tmp_path / "setup.toml"
    assert main(["inspect", five, "-m", "xyzac-trunnion", "--write-setup", str(sheet)]) == 0
    load_setup(sheet)
    before = sheet.read_text()
    assert main(["inspect", five, "-m", "xyzac-trunnion", "--write-setup", str(sheet)]) == 2
    assert "is there already; give another name" in capsys.readouterr().err and sheet.read_text() == before


def test_wrong_options_are_one_line(five, tmp_path, capsys):
    sheet = tmp_path / "setup.toml"
    sheet.write_text("[offsets.G54]\nX = 'far'\n")
    for arguments, words in (
        (["--setup", str(sheet)], "X = 'far' is not a number"),
        (["--controller", "fanucc"], "controller 'fanucc' is not known"),
        (["--compensation", "centre"], "--compensation 'centre' is not known"),
        (["--max-blocks", "0"], "--max-blocks 0"),
        (["-m", "xyzac"], "unknown machine 'xyzac'"),
        (["--feed", "fast"], "fast"),
    ):
        capsys.readouterr()
        assert main(["inspect", five, *arguments]) == 2
        said = capsys.readouterr()
        assert said.out == "" and said.err.startswith("error: ") and said.err.count("\n") == 1 and words in said.err


def test_lenient_lists_what_it_reads_on_as_assumed(tmp_path, capsys):
    path = tmp_path / "open.ngc"
    path.write_text("G21 G90 G94\nG0 X1\nG1 X3 F100\n")
    as_linuxcnc = [str(path), "--controller", "linuxcnc", "--machine", "xyzac-trunnion"]
    code, (found,) = inspected(capsys, *as_linuxcnc)
    assert code == 2 and "M2" in found["refused"][0]["word"] and found["assumed"] == []
    code, (found,) = inspected(capsys, *as_linuxcnc, "--lenient")
    assert code == 0 and found["refused"] == []
    (sentence,) = found["assumed"]
    assert sentence.startswith("read, though the control stops there: the end")
    path.write_text("G21 G90 G94\nG0 X1\nG1 X3 F100\nG99.5\n")
    code, (found,) = inspected(capsys, *as_linuxcnc, "--lenient")
    assert code == 2 and [each["word"] for each in found["refused"]] == ["G99.5"]


def test_what_the_program_says_wrong_goes_before_what_a_machine_lacks(tmp_path, capsys):
    """The file is cut off for every machine, while only some lack A."""
    cut = tmp_path / "cut.nc"
    cut.write_text("%\nG21 G90\nG0 X0 Y0 Z5 A0\nG1 X1 F100\n")
    _, (found,) = inspected(capsys, str(cut))
    assert "cut off" in found["refused"][0]["cure"]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("part.ngc", "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 X20\nG1 X20 A10\nM2\n"),
        ("part.apt", "MULTAX/ON\nUNITS/MM\nGOTO/0,0,50,0,0,1\nGOTO/20,0,50,0,0.1,1\nFINI\n"),
        ("part.csv", "x [mm],y [mm],z [mm],i,j,k\n0,0,50,0,0,1\n20,0,50,0,0.1,1\n"),
    ],
)
def test_a_missing_feed_is_needed_and_not_refused(name, text, tmp_path, capsys):
    """Twenty millimetres of it are read all the same, and `--feed` plans it."""
    program = tmp_path / name
    program.write_text(text)
    assert main(["inspect", str(program), "-m", "xyzac-trunnion", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found["refused"] == [] and found["machines"] == ["xyzac-trunnion"]
    (need,) = found["needs"]
    assert need.startswith("line ") and "feed missing" in need and "--feed 3000mm/min" in need
    assert found["tip_mm"][0] == pytest.approx([0.0, 20.0]) and found["five_axis_blocks"] == 1
    assert main(["inspect", str(program), "-m", "xyzac-trunnion"]) == 0
    page = " ".join(capsys.readouterr().out.split())
    assert "nothing: every word is read" in page and "needs line" in page
    assert main(["inspect", str(program), "-m", "xyzac-trunnion", "--feed", "100mm/min", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["needs"] == []


def test_what_is_refused_besides_a_missing_feed_is_refused(tmp_path, capsys):
    program = tmp_path / "part.ngc"
    program.write_text("G21 G90 G94\nG0 X0 Y0 Z50\nG1 X20\nG2 X30\nM2\n")
    assert main(["inspect", str(program), "-m", "xyzac-trunnion", "--json"]) == 2
    (found,) = json.loads(capsys.readouterr().out)
    assert "lacks its centre" in found["refused"][0]["cure"] and len(found["needs"]) == 1
