"""The commands, from program to verdict."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import toolpace as tp
from toolpace.cli import demo_programs, main
from toolpace.cli.app import app
from toolpace.machine.file_writer import pose_table
from toolpace.machine.machine import Machine
from toolpace.planning.limit_tolerances import PROMISED

CONTRACT = {
    "duration_s", "lower_bound_s", "gap", "solve_s", "fit_s", "mesh_points", "blocks", "stops", "usage", "limited_by",
    "tip_deviation_mm", "axis_deviation_deg", "machine", "program", "toolpace_version", "step_s",
}  # fmt: skip


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """A folder with a program and its plan."""
    folder = tmp_path_factory.mktemp("cli")
    program = folder / "blade.ngc"
    program.write_text(demo_programs.spiral_program(150))
    code = main(["plan", str(program), "--machine", "xyzac-trunnion", "--out", str(folder / "plan"), "--csv"])
    assert code == 0
    return folder


def test_plan_writes_the_contract(planned):
    plan = json.loads((planned / "plan" / "plan.json").read_text())
    assert set(plan) >= CONTRACT
    assert plan["blocks"] == 158 and plan["stops"] == 0 and plan["machine"] == "xyzac-trunnion"
    assert set(plan["usage"]) == {"feed", "velocity", "acceleration", "jerk"}
    peaks = [
        plan["usage"]["feed"],
        *(r for k in ("velocity", "acceleration", "jerk") for r in plan["usage"][k].values()),
    ]
    assert 0.99 < max(peaks) <= PROMISED
    assert abs(sum(plan["limited_by"].values()) - 1.0) < 1e-6
    assert plan["tip_deviation_mm"] <= 0.01 and plan["axis_deviation_deg"] <= 0.05
    assert set(plan["step_s"]) >= {"reading", "fitting", "planning", "bounding", "sampling", "verifying", "writing"}
    assert plan["verified"] is True


def test_plan_writes_the_files(planned):
    names = {path.name for path in (planned / "plan").iterdir()}
    assert names == {
        "plan.json", "setpoints.npz", "trajectory.compact", "setpoints.csv", "report.html", "machine.toml",
        "controller.toml", "program.ngc",
    }  # fmt: skip
    points = tp.SetPoints.load(planned / "plan" / "setpoints.npz")
    plan = json.loads((planned / "plan" / "plan.json").read_text())
    assert points.t[-1] == pytest.approx(plan["duration_s"], abs=1e-3)
    assert [path.name for path in planned.iterdir() if path.name.startswith(".")] == []


def test_verify_from_the_files_alone(planned, capsys):
    (planned / "blade.ngc").rename(planned / "gone.ngc")
    try:
        assert main(["verify", str(planned / "plan")]) == 0
    finally:
        (planned / "gone.ngc").rename(planned / "blade.ngc")
    output = capsys.readouterr().out
    assert "VERIFIED" in output and "jerk of C" in output and "tip, set-points to program" in output


@pytest.mark.parametrize("name, column, kind", [("q", 2, "program"), ("t", None, "time step")])
def test_verify_fails_with_1_on_a_changed_file(planned, tmp_path, capsys, name, column, kind):
    for path in (planned / "plan").iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    with np.load(tmp_path / "setpoints.npz") as archive:
        arrays = dict(archive)
    changed = arrays[name] = arrays[name].copy()
    if column is None:
        changed[len(changed) // 2] += 1e-4
    else:
        changed[:, column] += 2e-5
    np.savez(tmp_path / "setpoints.npz", **arrays)
    assert main(["verify", str(tmp_path)]) == 1
    output = capsys.readouterr().out
    assert "FAILED" in output and kind in output


def test_summary_is_for_machinists(planned, capsys):
    out = planned / "again"
    code = main(["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--out", str(out), "--no-report"])
    output = capsys.readouterr().out
    assert code == 0
    for step in ("reading", "fitting", "planning", "bounding", "sampling", "verifying", "writing"):
        assert re.search(rf"^{step} +\d[\d.]* m?s", output, re.MULTILINE)
    assert re.search(r"duration +\d\.\d\d s *\n", output)
    assert re.search(r"limited by +\w+.* \d+ %", output)
    assert "off the program, allowed" in output and "VERIFIED" in output
    assert f"{out}: plan.json, setpoints.npz, trajectory.compact, machine.toml, program.ngc" in output.replace("\n", "")
    assert not (out / "report.html").exists()


def test_second_order_says_that_jerk_limits_are_not_held(planned, capsys):
    out = planned / "second"
    assert main(["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--planner", "second-order", "--out",
                 str(out)]) == 1  # fmt: skip
    output = capsys.readouterr().out
    assert "gap to the best possible not known: the planner second-order gives no lower bound" in output
    assert "JERK LIMITS ARE NOT HELD" in output and "FAILED" in output and re.search(r"jerk +jumps +jumps", output)
    plan = json.loads((out / "plan.json").read_text())
    assert plan["planner"] == "second-order" and plan["verified"] is False and plan["lower_bound_s"] is None
    assert set(plan["usage"]["jerk"].values()) == {None} and plan["usage"]["feed"] <= PROMISED
    assert "unbounded" in (out / "report.html").read_text(encoding="utf-8")
    assert main(["verify", str(out)]) == 1
    failed = [line for line in capsys.readouterr().out.splitlines() if line.endswith("FAILED ")]
    # the positions show it, and so does what plan.json says of the jerk
    assert {line.split()[0] for line in failed} == {"jerk", "rest", "plan.json"}
    figures = [" ".join(line.split()[:3]) for line in failed if line.split()[0] == "plan.json"]
    assert set(figures) <= {"plan.json usage jerk", "plan.json usage"}, figures


def test_prove_raises_the_bound_and_says_where_it_stays_open(planned, capsys):
    out = planned / "proved"
    assert main(["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--prove", "--prove-within", "5s", "--out",
                 str(out)]) == 0  # fmt: skip
    output = capsys.readouterr().out
    assert re.search(r"proving .* gap [\d.]+ %, now [\d.]+ %", output) and "slower than any possible motion" in output
    before, after = (json.loads((planned / name / "plan.json").read_text()) for name in ("plan", "proved"))
    assert before["lower_bound_s"] <= after["lower_bound_s"] <= after["duration_s"] == before["duration_s"]
    assert 0.0 < before["continuous_bound_s"] <= before["duration_s"]
    assert 0.0 < after["continuous_bound_s"] <= after["duration_s"]
    assert all(place["from_s"] <= place["to_s"] and place["gain_s"] >= 0.0 for place in before["open_places"])
    assert main(["verify", str(out)]) == 0


def test_prices_are_shown_and_judged_where_they_are_asked_for(planned, capsys):
    words = ["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--effort", "low", "--no-report", "--prices"]
    out = planned / "priced"
    assert main([*words, "--out", str(out)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"jerk of C +10000 deg/s\^3 +[\d.]+ m?s, [\d.]+ % +[\d.]+ m?s, [\d.]+ %", output)
    assert "nothing saved by more of" in output
    plan = json.loads((out / "plan.json").read_text())
    assert list(plan["prices_s"].values()) == sorted(plan["prices_s"].values(), reverse=True)
    assert json.loads((planned / "plan" / "plan.json").read_text())["prices_s"] == {}
    assert main(["verify", str(out)]) == 0
    assert re.search(r"plan.json prices_s .* ok", capsys.readouterr().out)
    assert main([*words, "--planner", "genetic"]) == 2
    assert "--prices goes with the planner 'optimal'" in capsys.readouterr().err


def test_prove_goes_with_the_optimal_planner_only(planned, capsys):
    words = ["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--prove"]
    assert main([*words, "--planner", "genetic"]) == 2
    assert "optimal" in capsys.readouterr().err
    assert main([*words, "--prove-within", "soon"]) == 2
    assert "time" in capsys.readouterr().err


def test_feed_options_rank_as_they_should(planned, capsys):
    durations = {}
    for feed in ("none", "120%", "1500mm/min"):
        out = planned / re.sub(r"\W", "-", feed)
        assert main(["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--feed", feed, "--out", str(out),
                     "--no-report"]) == 0  # fmt: skip
        durations[feed] = json.loads((out / "plan.json").read_text())["duration_s"]
        assert main(["verify", str(out)]) == 0
    programmed = json.loads((planned / "plan" / "plan.json").read_text())["duration_s"]
    assert durations["none"] < durations["120%"] < programmed < durations["1500mm/min"]


def test_tolerance_and_time_step_are_obeyed(planned):
    out = planned / "fine"
    assert main(["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--tip-tolerance", "2um",
                 "--axis-tolerance", "0.01deg", "--dt", "2ms", "--out", str(out), "--no-report"]) == 0  # fmt: skip
    plan = json.loads((out / "plan.json").read_text())
    assert plan["tip_deviation_mm"] <= 0.002 and plan["axis_deviation_deg"] <= 0.01
    assert np.allclose(np.diff(tp.SetPoints.load(out / "setpoints.npz").t), 2e-3)


@pytest.mark.sweep
def test_tool_length_moves_the_machine_not_the_part(planned):
    for length in ("100mm", "180mm"):
        out = planned / length
        assert main(["plan", str(planned / "blade.ngc"), "-m", "xyzac-trunnion", "--tool-length", length, "--out",
                     str(out), "--no-report"]) == 0  # fmt: skip
    short, long = (tp.SetPoints.load(planned / length / "setpoints.npz") for length in ("100mm", "180mm"))
    assert np.allclose(long.q[0, 2] - short.q[0, 2], 0.08)
    assert np.allclose(long.tip[0], short.tip[0])


def test_default_folder_is_named_after_the_program(planned, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.txt").write_bytes((planned / "blade.ngc").read_bytes())
    assert main(["plan", "part.txt", "-m", "xyzac-trunnion", "--dialect", "gcode", "--no-report"]) == 0
    assert (tmp_path / "part-plan" / "plan.json").exists()
    assert main(["verify", "part-plan"]) == 0


def test_machines_lists_every_machine(capsys):
    assert main(["machines"]) == 0
    output = capsys.readouterr().out
    for name in Machine.names():
        assert f"{name}  " in output
    assert "table-table" in output and "head-head" in output and "deg/s^3" in output


def test_machine_file_printed_can_be_used(tmp_path, capsys):
    assert main(["machines", "xyzbc-head", "--toml"]) == 0
    file = tmp_path / "mine.toml"
    file.write_text(capsys.readouterr().out)
    assert Machine.load(file).to_toml() == Machine.load("xyzbc-head").to_toml()


def test_poses_of_a_machine_file_are_printed_whole(tmp_path, capsys, monkeypatch):
    """Lines as wide as they are, whatever the terminal, so that columns stay aligned."""
    monkeypatch.setenv("COLUMNS", "40")
    file = tmp_path / "mine.toml"
    file.write_text(Machine.load("xyzbc-head").to_toml())
    assert main(["machines", str(file), "--poses"]) == 0
    output = capsys.readouterr().out
    assert pose_table(Machine.load("xyzbc-head").geometry).rstrip() in output
    assert "head-head, workpiece < bed > X > Y > Z > C > B > tool" in output
    assert main(["machines", str(file)]) == 0
    assert "axis x" not in capsys.readouterr().out


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == tp.__version__


@pytest.mark.parametrize("command", [[], ["plan"], ["verify"], ["machines"], ["demo"], ["study"]])
def test_help_teaches_on_80_columns(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert main([*command, "--help"]) == 0
    output = capsys.readouterr().out
    assert max(map(len, output.splitlines())) <= 80
    if command not in (["demo"], ["study"]):
        assert "    toolpace " in output


@pytest.mark.parametrize("command", ["plan", "time", "export", "setup", "batch"])
def test_help_keeps_what_stands_in_brackets(command, capsys, monkeypatch):
    """Names of tables and units are no markup."""
    monkeypatch.setenv("COLUMNS", "200")
    told = app[command].help
    bracketed = re.findall(r"\[[a-z_]+\]", told if isinstance(told, str) else "")
    assert main([command, "--help"]) == 0
    output = capsys.readouterr().out
    assert all(words in output for words in bracketed)
    if command == "time":
        assert bracketed and "(table [time])" in output and "([times] tool_change, in seconds)" in output
        assert "columns t [s] and joints [mm, deg]" in output


def test_output_into_a_closed_pipe_is_no_error():
    command = f"{sys.executable} -m toolpace machines | head -1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=600)
    assert done.stderr == "" and done.stdout.startswith("linuxcnc")


INTERRUPTED = """
import os, signal, sys, threading
from contextlib import contextmanager
from toolpace.cli import main
from toolpace.cli.app import app
from toolpace.cli.console import Steps

under_way, plain = threading.Event(), Steps.step

@contextmanager
def watched(steps, name, note=""):
    with plain(steps, name, note) as step:
        shown = step.share
        def share(done):
            shown(done)
            if name == sys.argv[1] and 0.0 < done < 1.0:
                under_way.set()
        step.share = share
        yield step

def interrupt():
    under_way.wait()
    os.kill(os.getpid(), signal.SIGINT)

Steps.step = watched
threading.Thread(target=interrupt, daemon=True).start()
sys.exit(main(sys.argv[2:]))
"""
"""A command that meets Ctrl-C while the step that is named is at work."""


@pytest.mark.parametrize(
    "step, effort", [("fitting", "normal"), pytest.param("planning", "low", marks=pytest.mark.sweep)]
)
def test_ctrl_c_within_a_step_ends_it_and_leaves_nothing(step, effort, tmp_path):
    (tmp_path / "blade.ngc").write_text(demo_programs.spiral_program(5_000))
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, step, "plan", "blade.ngc", "-m", "xyzac-trunnion", "--effort", effort],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.stderr == "error: interrupted; nothing was written\n" and done.returncode == 130
    # a step has its line when it is done
    assert not re.search(rf"^{step} ", done.stdout, re.MULTILINE)
    assert [path.name for path in tmp_path.iterdir()] == ["blade.ngc"]


@pytest.mark.parametrize("gap", [0.03, 0.0027])
def test_a_plan_far_above_its_bound_says_why(monkeypatch, tmp_path, capsys, gap):
    """One that another try has brought near it says nothing of how far it was before."""
    from toolpace.planning import program_plan as planner

    notes = tuple(f"run at s = {k}: gap of 3.0%, mostly a rest" for k in range(5))
    real = planner.plan

    def far(*given, **options):
        made = real(*given, **options)
        return replace(made, notes=notes, lower_bound=made.duration / (1.0 + gap))

    monkeypatch.setattr(planner, "plan", far)
    program = tmp_path / "part.ngc"
    program.write_text("G21 G90 G0 X0 Y0 Z10\nG1 X10 F1000\nG1 X20 Y5\nM30\n")
    assert main(["plan", str(program), "-m", "xyzac-trunnion", "-o", str(tmp_path / "out"), "--no-report"]) == 0
    said = capsys.readouterr().out
    if gap > 0.02:
        assert "run at s = 2: gap of 3.0%" in said and "s = 3" not in said and "and so of 2 more runs" in said
    else:
        assert "run at" not in said and "more runs" not in said and f"at most {100.0 * gap:.2g} % slower" in said
