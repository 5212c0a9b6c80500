"""`toolpace time`: in JSON as a contract, and on a page; figures from a log."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.s_curves import duration
from tests.support.trapezoids import log_of, program
from toolpace.cli import main
from toolpace.common.errors import InfeasibleError
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import OperationTime
from toolpace.programs.reading.controllers.controller import Controller

PROGRAM = (
    "G21 G90 G94\nG0 X0 Y0 Z10 A0 C0\nT1 M6\nG1 Z0 F1000\nG1 X40\nG1 Y30 A10\nG4 P1\nT2 M6\nG1 X0 C20\nG0 Z10\nM30\n"
)
MACHINE = ["-m", "xyzac-trunnion"]


@pytest.fixture
def part(tmp_path: Path) -> str:
    (tmp_path / "part.ngc").write_text(PROGRAM)
    return str(tmp_path / "part.ngc")


def printed(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> str:
    assert main(["time", *arguments]) == code
    return capsys.readouterr().out


def test_json_is_a_list_with_the_time_and_its_parts(part, tmp_path, capsys):
    (tmp_path / "setup.toml").write_text("[times]\ntool_change = 6.5\n")
    (tmp_path / "broken.ngc").write_text("G1 X\nM2\n")
    arguments = [part, str(tmp_path / "broken.ngc"), *MACHINE, "--model", "lookahead", "--json"]
    found = json.loads(printed(capsys, *arguments, "--setup", str(tmp_path / "setup.toml"), code=2))
    first, second = found
    assert first["program"] == part and first["error" if "error" in first else "model"] == "lookahead"
    parts = sum(first[f"{kind}_s"] for kind in ("cutting", "rapid", "dwell", "tool_change"))
    assert first["total_s"] == pytest.approx(parts)
    assert first["dwell_s"] == pytest.approx(1.0) and first["tool_change_s"] == pytest.approx(13.0)
    assert [each["tool"] for each in first["tools"]] == ["1", "2"]
    assert sum(each["total_s"] for each in first["operations"]) == pytest.approx(first["total_s"])
    least = sum(each["optimum_s"] for each in first["operations"]) + 13.0
    assert first["optimum_s"] == pytest.approx(least)
    assert second["total_s"] is None and second["optimum_s"] is None and "broken.ngc:1" in second["error"]


@pytest.mark.sweep
def test_the_optimum_is_that_of_plan_and_the_model_ideal_is_it(part, tmp_path, capsys):
    found = json.loads(printed(capsys, part, *MACHINE, "--model", "ideal", "--json"))[0]
    assert main(["plan", part, *MACHINE, "--out", str(tmp_path / "plan"), "--no-report"]) == 0
    plan = json.loads((tmp_path / "plan" / "plan.json").read_text())
    assert found["total_s"] == pytest.approx(plan["duration_s"], rel=1e-9)
    assert found["optimum_s"] == pytest.approx(plan["duration_s"], rel=1e-9)


def test_a_page_tells_operations_and_a_table_many_programs(part, capsys):
    page = printed(capsys, part, *MACHINE, "--model", "heidenhain", "--no-optimum")
    assert "positions filtered" in page and "tool change" in page and "optimum  " not in page
    step = next(line for line in page.splitlines() if line.startswith("moves"))
    assert f"{part}: 11 blocks" in step and page.count("moves  ") == 1
    table = printed(capsys, part, part, *MACHINE, "--model", "lookahead", "--no-optimum")
    assert table.count("part.ngc") >= 2 and "saving" not in table


def test_the_figures_of_a_control_stand_in_its_file(part, tmp_path, capsys):
    file = tmp_path / "slow.toml"
    file.write_text(
        'name = "slow"\nlike = "fanuc"\n[time]\nmodel = "lookahead"\nacceleration = 0.1\nblock_time = 2.0\n'
    )
    totals = []
    for controller in ("fanuc", str(file)):
        arguments = [part, *MACHINE, "--controller", controller, "--no-optimum", "--json"]
        totals.append(json.loads(printed(capsys, *arguments))[0]["total_s"])
    assert totals[1] > totals[0] + 1.0
    file.write_text('name = "slow"\nlike = "fanuc"\n[time]\ntolerence = 0.1\n')
    assert main(["time", part, *MACHINE, "--controller", str(file)]) == 2
    assert "tolerence" in capsys.readouterr().err


def test_the_tolerance_of_the_program_holds_for_the_control_and_for_the_optimum(tmp_path, capsys):
    (tmp_path / "part.mpf").write_text(
        "G71 G90 G94\nG0 X0 Y0 Z0 A0 C0\nCYCLE832(0.05, 1)\nG1 X20 F6000\nY20\nX0\nM30\n"
    )
    part = [str(tmp_path / "part.mpf"), *MACHINE]
    (own,) = json.loads(printed(capsys, *part, "--json"))
    assert own["model"] == "sinumerik" and own["program_tolerance_mm"] == [pytest.approx(0.05)] * 2
    wide, narrow = (
        json.loads(printed(capsys, *part, "--tip-tolerance", each, "--json"))[0] for each in ("50um", "5um")
    )
    assert own["optimum_s"] == pytest.approx(wide["optimum_s"], rel=1e-9) and narrow["optimum_s"] > own["optimum_s"]
    page = printed(capsys, *part, "--no-optimum")
    assert "0.05 mm, as the program asks for" in page
    (tmp_path / "part.mpf").write_text("G71 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F6000\nY20\nM30\n")
    assert "the program asks for none; 0.01 mm" in printed(capsys, *part, "--no-optimum")
    # then the control's own tolerance holds for both
    (tmp_path / "wide.toml").write_text('name = "wide"\nlike = "sinumerik"\n[time]\ntolerance = 0.05\n')
    narrow, wide = (
        json.loads(printed(capsys, *part, *how, "--json"))[0]
        for how in ((), ("--controller", str(tmp_path / "wide.toml")))
    )
    assert wide["optimum_s"] < narrow["optimum_s"] and wide["total_s"] < narrow["total_s"]


def test_limits_that_the_control_exceeds_are_named_with_place_and_size(tmp_path, capsys):
    (tmp_path / "part.nc").write_text("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F6000\nY20\nX0\nM30\n")
    part = [str(tmp_path / "part.nc"), *MACHINE, "--model", "fanuc", "--no-optimum"]
    found = json.loads(printed(capsys, *part, "--json"))[0]["exceeded"]
    # 500 mm/min of X and of Y in 1 ms, at both corners
    limits = Machine.load("xyzac-trunnion").limits
    change = 500.0 / 6e4
    worst = {(each["kind"], each["axis"]): each for each in found}
    for axis in (0, 1):
        name = "XY"[axis]
        assert worst["acceleration", name]["ratio"] == pytest.approx(change / 1e-3 / limits.acceleration[axis])
        assert worst["jerk", name]["ratio"] == pytest.approx(4.0 * change / 1e-6 / limits.jerk[axis])
        jerk = worst["jerk", name]
        assert jerk["where"] == "corner" and jerk["count"] == 2 and jerk["line"] in (3, 4)
    assert "times its limit in 2 corners, worst at line" in " ".join(printed(capsys, *part).split())
    part[part.index("fanuc")] = "lookahead"
    assert json.loads(printed(capsys, *part, "--json"))[0]["exceeded"] == []


def test_the_optimum_is_planned_with_the_limits_that_the_control_exceeds_too(tmp_path, capsys):
    """A line from rest to rest: LinuxCNC's acceleration begins within a cycle of 1 ms."""
    (tmp_path / "part.ngc").write_text("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F6000\nM2\n")
    part = [str(tmp_path / "part.ngc"), *MACHINE, "--model", "linuxcnc"]
    (found,) = json.loads(printed(capsys, *part, "--json"))
    limits = Machine.load("xyzac-trunnion").limits
    acceleration, jerk = limits.acceleration[0], limits.jerk[0]
    assert [each["kind"] for each in found["exceeded"]] == ["jerk"]
    assert found["optimum_s"] == pytest.approx(duration(0.02, 0.1, acceleration, jerk)[1], rel=1e-3)
    assert found["optimum_likewise_s"] == pytest.approx(
        duration(0.02, 0.1, acceleration, acceleration / 1e-3)[1], rel=1e-3
    )
    page = " ".join(printed(capsys, *part).split())
    assert "in the ramps of at most 1 block" in page and "likewise" in page


@pytest.mark.parametrize("fails", [False, True])
def test_raised_limits_ask_nothing_and_end_nothing(tmp_path, capsys, monkeypatch, fails):
    """The jumps of a Fanuc take some hundred times the jerk, which nobody wrote in another unit."""
    (tmp_path / "part.nc").write_text("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F6000\nY20\nX0\nM30\n")
    own, planned = Machine.load("xyzac-trunnion").limits, []

    def optimum_of(task, steps):
        planned.append(task.machine.limits.jerk[0])
        if fails and len(planned) % 2 == 0:
            raise InfeasibleError("no motion")
        return (OperationTime("", "", 3.0 / len(planned), 0.0, 0.0, 0),)

    monkeypatch.setattr("toolpace.jobs.timed.optimum_of", optimum_of)
    part = [str(tmp_path / "part.nc"), *MACHINE, "--model", "fanuc"]
    assert main(["time", *part]) == 0
    said = capsys.readouterr()
    assert said.err == "" and planned[0] == own.jerk[0] and planned[1] > 100.0 * own.jerk[0]
    assert ("left out, since no motion was found with these limits: no motion" in " ".join(said.out.split())) == fails
    assert ("likewise" in said.out) != fails and "optimum" in said.out
    (found,) = json.loads(printed(capsys, *part, "--json"))
    assert (found["optimum_likewise_s"] is None) == fails and found["optimum_s"] is not None


def test_operations_that_are_called_alike_have_each_its_own_optimum(tmp_path, capsys, monkeypatch):
    """Tool 1, tool 2, tool 1 again: the optimum of the last stood beside the first, too."""
    (tmp_path / "part.ngc").write_text(
        "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nT1 M6\nG1 X40 F1000\nT2 M6\nG1 Y30\nT1 M6\nG1 X0\nM30\n"
    )
    best = [OperationTime("", tool, time, 0.0, 0.0, 0) for tool, time in (("1", 2.0), ("2", 1.0), ("1", 0.5))]
    monkeypatch.setattr("toolpace.jobs.timed.optimum_of", lambda task, steps: tuple(best))
    part = [str(tmp_path / "part.ngc"), *MACHINE, "--model", "lookahead"]
    (found,) = json.loads(printed(capsys, *part, "--json"))
    told = [(each["tool"], each["optimum_s"]) for each in found["operations"] if each["tool"]]
    assert told == [("1", 2.0), ("2", 1.0), ("1", 0.5)]
    rows = [line.split() for line in printed(capsys, *part).splitlines()]
    assert [row[-2] for row in rows if row[:2] in (["-", "1"], ["-", "2"])] == ["2.00", "1.00", "500"]


def test_the_range_is_told_with_what_it_is_mostly_from(part, tmp_path, capsys):
    (tmp_path / "mine.toml").write_text(
        'name = "mine"\nlike = "linuxcnc"\n[time]\nmodel = "lookahead"\n[time.uncertainty]\n'
        "acceleration = 1.0\njerk.X = 3.0\njerk.Y = 1.0\njerk.Z = [0.5, 2.0]\njerk.A = 1.0\njerk.C = 1.0\n"
    )
    mine = [part, *MACHINE, "--controller", str(tmp_path / "mine.toml"), "--no-optimum"]
    assert main(["time", *mine]) == 2  # ends hold the figure itself, in mm/s^3
    assert "jerk.Z: the figure, " in capsys.readouterr().err
    (tmp_path / "mine.toml").write_text((tmp_path / "mine.toml").read_text().replace("[0.5, 2.0]", "1.0"))
    (found,) = json.loads(printed(capsys, *mine, "--json"))
    assert found["range_s"][0] < found["total_s"] < found["range_s"][1]
    assert found["uncertain"][0]["figure"] == found["range_mostly_from"] == "jerk of X"
    assert "with all figures off at once, mostly from jerk of X" in " ".join(printed(capsys, *mine).split())
    assert " % to +" in printed(capsys, part, *mine)


def test_one_measured_time_makes_a_controllers_file(part, tmp_path, capsys):
    target = tmp_path / "mine.toml"
    measured = [part, *MACHINE, "--model", "lookahead"]
    said = printed(capsys, *measured, "--fit", "9.00 s", "--write-controller", str(target))
    assert "jerk" in said and "times the machine's (" in said
    (found,) = json.loads(printed(capsys, part, *MACHINE, "--controller", str(target), "--no-optimum", "--json"))
    assert found["total_s"] == pytest.approx(9.00, abs=0.02)
    (tmp_path / "times.txt").write_text("T1, 1:00\nT9, 2:00\n")
    assert main(["time", *measured, "--fit", str(tmp_path / "times.txt")]) == 2
    assert "the program has no operation 'T9'; known: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--model", "linux"], "did you mean"),
        (["--model", "fir"], "there is no such model any more; take heidenhain or fanuc"),
        (["--write-controller", "a.toml"], "goes with --fit"),
        (["--fit", "none.csv"], "cannot be read"),
        (["--fit", "3:75"], "or give one time, such as 3:12"),
    ],
)
def test_wrong_options_are_one_line(part, arguments, told, capsys):
    assert main(["time", part, *MACHINE, *arguments]) == 2
    error = capsys.readouterr().err
    assert told in error and len(error.strip().splitlines()) == 1


def test_a_machine_is_needed(part, capsys):
    assert main(["time", part]) == 2
    assert "--machine is missing" in capsys.readouterr().err


def test_figures_from_a_log_make_a_controllers_file(tmp_path, capsys):
    (tmp_path / "part.ngc").write_text(program())
    log = log_of()
    rows = (",".join([f"{k * log.dt:.4f}", *(f"{1e3 * value:.9f}" for value in q[:3])]) for k, q in enumerate(log.q))
    (tmp_path / "log.csv").write_text("\n".join(["t,X,Y,Z", *rows]))
    target = tmp_path / "mine.toml"
    fit = [str(tmp_path / "part.ngc"), *MACHINE, "--fit", str(tmp_path / "log.csv"), "--model", "lookahead"]
    assert "[time.acceleration]" in printed(capsys, *fit)
    assert "mine.toml" in printed(capsys, *fit, "--write-controller", str(target))
    timed = [str(tmp_path / "part.ngc"), *MACHINE, "--controller", str(target), "--no-optimum", "--json"]
    found = json.loads(printed(capsys, *timed))[0]
    assert found["total_s"] == pytest.approx(log.duration, rel=0.01)
    least, most = found["range_s"]
    # a row of the log is lost at each of six stops
    assert least <= log.duration <= most + 6.0 * log.dt and most < 1.05 * least
    # what is there already is never replaced
    assert main(["time", *fit, "--write-controller", str(target)]) == 2
    assert "is there already" in capsys.readouterr().err
    cut = tmp_path / "cut.toml"
    lines = (tmp_path / "log.csv").read_text().splitlines()
    (tmp_path / "log.csv").write_text("\n".join(lines[:-50]))
    said = printed(capsys, *fit, "--write-controller", str(cut))
    assert "in doubt: the axes are in motion where the log ends" in " ".join(said.split())
    assert cut.read_text().startswith("# in doubt: the axes are in motion where the log ends: rows are missing")
    assert Controller.load(cut).time["model"] == "lookahead"


@pytest.mark.parametrize("model", ["linuxcnc", "sinumerik", "heidenhain", "fanuc", "lookahead", "ideal"])
@pytest.mark.parametrize("before", ["", "G0 X1 Y2 Z3 A0 C0\n"], ids=["no place", "a place"])
def test_a_program_that_only_waits_takes_what_it_waits(tmp_path, capsys, model, before):
    file = tmp_path / "warm_up.ngc"
    file.write_text(f"G21 G90 G94\n{before}G4 P2\nM3 S500\nG4 P1.5\nM2\n")
    (found,) = json.loads(printed(capsys, str(file), *MACHINE, "--model", model, "--json"))
    assert found["total_s"] == found["dwell_s"] == found["optimum_s"] == 3.5
    assert "3.50 s" in printed(capsys, str(file), *MACHINE, "--model", model)
    (found,) = json.loads(printed(capsys, str(file), *MACHINE, "--model", "heidenhain", "--no-optimum", "--json"))
    assert found["total_s"] == 3.5 and found["optimum_s"] is None


def test_what_neither_moves_nor_waits_is_no_program(tmp_path, capsys):
    (tmp_path / "part.ngc").write_text("G21 G90\nM3 S500\nM2\n")
    assert main(["time", str(tmp_path / "part.ngc"), *MACHINE]) == 2
    assert "there is no motion in the program" in capsys.readouterr().err
    (tmp_path / "part.ngc").write_text("G4 P2\nM2\n")
    (tmp_path / "log.csv").write_text("t,X,Y,Z\n" + "".join(f"{k / 100},{k},0,0\n" for k in range(50)))
    assert main(["time", str(tmp_path / "part.ngc"), *MACHINE, "--fit", str(tmp_path / "log.csv")]) == 2
    assert "nothing moves in the program: no figure" in capsys.readouterr().err


PLACES = {
    "a folder that is missing": ("none/mine.toml", "there is no folder none; make it"),
    "a folder": (".", "is a folder"),
    "a file that is there": ("part.ngc", "is there already; give another name"),
    "a file for a folder": ("part.ngc/mine.toml", "there is no folder part.ngc"),
    "a name that is too long": ("m" * 300, "cannot be written: file name too long"),
    "no name": ("", "the name of the file is empty"),
    "a folder that takes no files": ("/proc/mine.toml", "cannot be written"),
}


@pytest.mark.parametrize(
    ("command", "option"),
    [(["time", "--fit", "log.csv", "--model", "heidenhain"], "--write-controller"), (["inspect"], "--write-setup")],
)
@pytest.mark.parametrize(("place", "told"), PLACES.values(), ids=PLACES)
def test_a_place_for_a_file_is_tried_before_the_work(part, tmp_path, capsys, monkeypatch, command, option, place, told):
    """Neither the program nor the log is read before it: both are missing here."""
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    assert main([*command, "missing.ngc", *MACHINE, option, place]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {option} ") and told in error and error.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


TWO_WAYS = ("--model", "lookahead"), ("--model", "lookahead", "--no-optimum")


@pytest.mark.parametrize("how", TWO_WAYS)
def test_a_program_that_leaves_the_travel_is_refused_planned_or_not(tmp_path, capsys, how):
    file = tmp_path / "long.ngc"
    file.write_text(PROGRAM.replace("X40", "X4000"))
    assert main(["time", str(file), *MACHINE, *how]) == 2
    said = capsys.readouterr().err
    assert "long.ngc:5: joint X would have to go to" in said and "its limit of" in said
    assert main(["plan", str(file), *MACHINE, "--out", str(tmp_path / "plan"), "--no-report"]) == 2
    assert said.splitlines()[-1] == capsys.readouterr().err.splitlines()[-1]


@pytest.mark.sweep
def test_rests_of_a_control_are_told_apart_from_the_stops_of_a_program(part, tmp_path, capsys):
    """Two ways between rapid and feed, a dwell and a tool change: two stops of the program, two rests more."""
    (found,) = json.loads(printed(capsys, part, *MACHINE, "--model", "lookahead", "--no-optimum", "--json"))
    assert all("stops" not in each for each in found["operations"])
    assert main(["inspect", part, "--json"]) == 0
    (inspected,) = json.loads(capsys.readouterr().out)
    assert main(["plan", part, *MACHINE, "--out", str(tmp_path / "plan"), "--no-report"]) == 0
    stops = json.loads((tmp_path / "plan" / "plan.json").read_text())["stops"]
    rests = sum(each["rests"] for each in found["operations"])
    assert stops == inspected["stops"] and rests > stops
    capsys.readouterr()
    page = printed(capsys, part, *MACHINE, "--model", "lookahead", "--no-optimum")
    assert "rests" in page and "stops" not in page
