"""`toolpace setup`: a folder that is whole, and loads; errors of one line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import toolpace as tp
from testbed.curved_pass import curved_pass
from testbed.true_tip.cases import Maker
from toolpace.cli import main
from toolpace.results.write import read_plan
from toolpace.results.write.set_up_folder import cldata_text

QUICK = ["--trials", "24", "--workers", "0", "--no-map"]


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = tmp_path_factory.mktemp("part") / "part.apt"
    program.write_text(cldata_text(curved_pass(160)))
    return program


@pytest.mark.sweep
def test_the_folder_holds_what_is_to_be_loaded(part, tmp_path, capsys):
    out = tmp_path / "found"
    arguments = ["setup", str(part), "-m", "xyzac-trunnion", "--trials", "24", "--shown", "4", "--workers", "0"]
    arguments += ["--out", str(out)]
    assert main(arguments) == 0
    told = capsys.readouterr().out
    assert "before" in told and "after" in told and "given" in told
    names = {"setup.json", "setup.html", "map.svg", "setup.toml", "machine.toml", "program.apt"}
    assert {file.name for file in out.iterdir()} == names
    record = json.loads((out / "setup.json").read_text())
    assert record["duration_s"] < record["given_duration_s"] and record["duration_s"] >= record["lower_bound_s"]
    assert record["gain"] == pytest.approx(1.0 - record["duration_s"] / record["given_duration_s"])
    assert len(record["set_ups"]) == 4 and len(record["map"]["seconds"]) == 9
    page = (out / "setup.html").read_text()
    assert "Time over the place" in page and "Content-Security-Policy" in page and page.count("<script>") == 1
    plan = tmp_path / "plan"
    ways = (["-m", str(out / "machine.toml")], ["-m", "xyzac-trunnion", "--setup", str(out / "setup.toml")])
    for way in ways if record["set_ups"][0]["solution"] == 0 else ways[:1]:
        assert main(["plan", str(out / "program.apt"), *way, "--out", str(plan), "--effort", "low", "--no-report"]) == 0
        duration = json.loads((plan / "plan.json").read_text())["duration_s"]
        assert duration == pytest.approx(record["duration_s"], rel=1e-6)
    # the same again takes the place of what toolpace wrote
    assert main([*arguments, "--no-map"]) == 0 and not (out / "map.svg").exists()


@pytest.mark.sweep
def test_rows_lead_to_the_plans_of_the_set_ups(part, tmp_path):
    out, plans = tmp_path / "found", tmp_path / "a b"
    arguments = ["setup", str(part), "-m", "xyzac-trunnion", *QUICK, "--shown", "2", "--out", str(out)]
    assert main([*arguments, "--plans", str(plans)]) == 0
    links = re.findall(r'<a href="([^"]+)">', (out / "setup.html").read_text(encoding="utf-8"))
    assert links == ["../a%20b/1/report.html", "../a%20b/2/report.html"]
    record = json.loads((out / "setup.json").read_text())
    for number, found in enumerate(record["set_ups"], start=1):
        plan = read_plan(plans / str(number))
        assert plan.verified and plan.duration_s == pytest.approx(found["duration_s"], rel=1e-6)
        assert (plans / str(number) / "report.html").is_file()


@pytest.mark.sweep
def test_several_machines_are_held_against_each_other(part, tmp_path, capsys):
    out = tmp_path / "found"
    machines = "xyzac-trunnion,xyzbc-head"
    assert main(["setup", str(part), "--machines", machines, *QUICK, "--shown", "2", "--out", str(out)]) == 0
    record = json.loads((out / "setup.json").read_text())
    found = {each["machine"]: each for each in record["machines"]}
    assert list(found) == machines.split(",")
    times = [each["duration_s"] for each in found.values() if "duration_s" in each]
    assert len(times) == 2 and record["duration_s"] == min(times)
    assert "Machines" in (out / "setup.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "--machine is missing"),
        (["-m", "xyzac-trunnion", "--machines", "xyzbc-head"], "--machine and --machines: give one of both"),
        (["--machines", "xyzbc-head,xyzbc-head"], "one machine is named twice"),
        (["-m", "xyzac-trunnion", "--trials", "2"], "--trials 2: so few find nothing; give at least 20"),
        (["-m", "xyzac-trunnion", "--shown", "0"], "--shown 0: give 1 to 1000"),
        (["-m", "xyzac-trunnion", "--choices", "nowhere.toml"], "choices nowhere.toml: cannot be read"),
        (["-m", "xyzac-trunnion", "--workers", "-1"], "--workers -1: give 1 or more, or 0 for this process"),
        (["-m", "xyzac-trunnion", "--workers", "2", "--cluster", "tcp://a:1"], "--cluster and --workers"),
    ],
)
def test_what_makes_no_sense_is_one_line(part, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert main(["setup", str(part), *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1 and not list(tmp_path.iterdir())


def test_a_program_that_fits_nowhere_leaves_nothing(part, tmp_path, capsys):
    machine = tp.Machine.load("xyzac-trunnion").mounted(x=(1.0, 0.0, 0.0), z=(0.0, 0.0, -1.0))
    (tmp_path / "mill.toml").write_text(machine.to_toml())
    out = tmp_path / "found"
    assert main(["setup", str(part), "-m", str(tmp_path / "mill.toml"), *QUICK, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert "clampings that were tried fits" in error and error.count("\n") == 1 and not out.exists()


@pytest.mark.sweep
def test_the_tools_of_the_sheet_are_those_of_the_search(tmp_path, capsys):
    """Two tools of lengths that are not the machine's: what was found is planned again from its folder, as long."""
    case = Maker(3, "xyzac-trunnion", "g43.4", [0.1, 0.2], points=20).make()
    program, sheet, out, plan = (tmp_path / name for name in ("two.nc", "two.toml", "found", "plan"))
    program.write_text(case.text)
    sheet.write_text(case.sheet)
    arguments = ["setup", str(program), "-m", case.machine, "--controller", "fanuc", "--setup", str(sheet)]
    assert main([*arguments, *QUICK, "--shown", "2", "--out", str(out)]) == 0
    assert "100, 200" in capsys.readouterr().out
    record = json.loads((out / "setup.json").read_text())
    assert record["set_ups"][0]["tool_lengths_mm"] == [100.0, 200.0]
    assert "# Tool: 100mm, 200mm from" in (out / "setup.toml").read_text()
    again = ["plan", str(out / "program.apt"), "-m", str(out / "machine.toml"), "--effort", "low", "--no-report"]
    assert main([*again, "--out", str(plan)]) == 0
    assert json.loads((plan / "plan.json").read_text())["duration_s"] == pytest.approx(record["duration_s"], rel=1e-6)
    points = tp.SetPoints.load(plan / "setpoints.npz")
    assert sorted(set(points.tool_length.tolist())) == [0.1, 0.2]
