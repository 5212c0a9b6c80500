"""Time by operation and tool: in the plan, in the summary, in the report, and before the judge."""

from __future__ import annotations

import json

import pytest

from toolpace.cli import main
from toolpace.common.files.seal import KEY, write_seal

PROGRAM = """\
G21 G90 G94
T1 M6
G0 X0 Y0 Z10
G1 Z0 F600
G1 X20
G4 P0.3
G0 Z10
G0 X50
T2 M6
G81 Z-3 R2 F300
X60
G80
G0 Z20
M30
"""


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    folder = tmp_path_factory.mktemp("operations")
    program = folder / "part.ngc"
    program.write_text(PROGRAM)
    arguments = ["--controller", "linuxcnc", "--out", str(folder / "out")]
    assert main(["plan", str(program), "-m", "xyzac-trunnion", *arguments]) == 0
    return folder / "out"


def figures(folder):
    return json.loads((folder / "plan.json").read_text())


@pytest.mark.sweep
def test_time_is_told_by_tool_and_kind_and_sums_up(planned):
    said = figures(planned)
    one, two = said["operations"]
    assert (one["tool"], two["tool"]) == ("1", "2") and one["dwell_s"] == 0.3 and two["dwell_s"] == 0.0
    for each in (one, two):
        assert each["time_s"] == pytest.approx(each["cutting_s"] + each["rapid_s"] + each["dwell_s"], abs=1e-12)
    for kind in ("cutting_s", "rapid_s", "dwell_s"):
        assert said[kind] == pytest.approx(one[kind] + two[kind], abs=1e-12)
    assert said["duration_s"] == pytest.approx(said["cutting_s"] + said["rapid_s"] + said["dwell_s"], abs=1e-9)
    # 30 mm at 600 mm/min, and twice from R at 2 mm to -3 mm at 300 mm/min; less would be above the feed
    assert 3.0 <= one["cutting_s"] <= 3.5 and 2.0 <= two["cutting_s"] <= 2.5
    # within one block of a cycle, down is at feed and up a rapid
    assert two["rapid_s"] > 0.2 and one["stops"] + two["stops"] == said["stops"]


def test_the_report_and_the_verdict_tell_of_it(planned, capsys):
    page = (planned / "report.html").read_text()
    assert "<h2>Operations</h2>" in page and "<td>2</td>" in page
    capsys.readouterr()
    assert main(["verify", str(planned)]) == 0
    assert "plan.json operations" in capsys.readouterr().out


def moved(said, kind, seconds):
    """Time told of the second tool's operation in place of the first's."""
    one, two = said["operations"]
    for each, share in ((one, -seconds), (two, seconds)):
        each[kind] += share
        each["time_s"] += share


@pytest.mark.parametrize("kind", ["cutting_s", "rapid_s"])
@pytest.mark.parametrize("seconds", [0.1, -0.1])
def test_time_that_is_told_of_another_operation_is_found(planned, tmp_path, capsys, kind, seconds):
    for path in planned.iterdir():
        if path.name != "report.html":
            (tmp_path / path.name).write_bytes(path.read_bytes())
    said = figures(planned)
    said.pop(KEY)
    moved(said, kind, seconds)
    (tmp_path / "plan.json").write_text(json.dumps(said))
    write_seal(tmp_path, "plan.json")
    capsys.readouterr()
    assert main(["verify", str(tmp_path)]) == 1
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith("FAILED  plan.json operations") and f"{kind} of operation" in last


@pytest.mark.sweep
def test_a_plan_says_that_its_duration_is_without_the_tool_changes_of_the_sheet(tmp_path, capsys):
    program, sheet = tmp_path / "part.ngc", tmp_path / "sheet.toml"
    program.write_text(PROGRAM)
    sheet.write_text("[times]\ntool_change = 6.5\n")
    given = ["plan", str(program), "-m", "xyzac-trunnion", "--controller", "linuxcnc", "--no-report"]
    assert main([*given, "--out", str(tmp_path / "with"), "--setup", str(sheet)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "the duration is without 2 tool changes of 6.50 s (set-up sheet, [times]): 13.00 s more" in said
    assert main([*given, "--out", str(tmp_path / "without")]) == 0
    assert "tool change" not in capsys.readouterr().out
    assert figures(tmp_path / "with")["duration_s"] == figures(tmp_path / "without")["duration_s"]
