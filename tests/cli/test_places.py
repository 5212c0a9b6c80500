"""Where programs come from and results go to: pipes, folders of one's own, output that goes away, signals."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from toolpace.cli import demo_programs, main
from toolpace.common.files.seal import foreign
from toolpace.machine.machine import Machine

PLAN = ("-m", "xyzac-trunnion", "--no-report")
TOOLPACE = f"{sys.executable} -m toolpace"
RESULTS = {"plan.json", "controller.toml", "setpoints.npz", "trajectory.compact", "machine.toml"}


@pytest.fixture(scope="module")
def blade():
    return demo_programs.spiral_program(30)


@pytest.fixture
def here(tmp_path, monkeypatch, blade):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.ngc").write_text(blade)
    return tmp_path


def content(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def names(folder):
    return [path.name for path in folder.iterdir()]


def shell(command, **given):
    return subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=600, **given)


def refused(capsys, arguments, *says):
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1 and error[:-1].isprintable()
    assert all(text in error for text in says), error
    return error


@pytest.mark.parametrize("command", [["plan", "part.ngc", *PLAN], ["demo"], ["study"]])
def test_ones_own_machine_and_program_are_never_overwritten(here, capsys, command):
    """The folder one is in, and one that holds a machine.toml and a program.ngc of one's own."""
    (here / "mine").mkdir()
    for name in ("machine.toml", "program.ngc", "plan.json"):
        (here / name).write_text(f"my {name}")
        (here / "mine" / name).write_text(f"my other {name}")
    before = content(here)
    refused(capsys, [*command, "-o", "."], "--out .: is the folder you are in")
    refused(capsys, [*command, "-o", "mine"], "--out mine: is not replaced", "give another folder")
    refused(capsys, [*command, "-o", ".."], "above the folder you are in")
    refused(capsys, [*command, "-o", "part.ngc"], "is a file")
    refused(capsys, [*command, "-o", "x" * 300], "file name too long")
    assert content(here) == before


@pytest.mark.sweep
def test_a_plan_is_replaced_a_plan_with_ones_own_file_is_not(here, capsys):
    assert main(["plan", "part.ngc", *PLAN, "-o", "out", "--csv"]) == 0
    assert main(["plan", "part.ngc", *PLAN, "-o", "out"]) == 0
    assert set(content(here / "out")) == RESULTS | {"program.ngc"}
    assert main(["plan", "out/program.ngc", "-m", "out/machine.toml", "--no-report", "-o", "out"]) == 0
    assert foreign(here / "out") == "" and sorted(names(here)) == ["out", "part.ngc"]
    (here / "out" / "notes.txt").write_text("mine")
    before = content(here)
    capsys.readouterr()
    refused(capsys, ["plan", "part.ngc", *PLAN, "-o", "out"], "holds notes.txt, which toolpace did not write")
    assert content(here) == before


@pytest.mark.sweep
@pytest.mark.parametrize(
    "command",
    [
        "cat part.ngc | {t} plan - {p}; mv program-plan out",
        pytest.param(
            "{t} plan <(cat part.ngc) -m <({t} machines xyzac-trunnion --toml) --no-report -o out",
            marks=pytest.mark.sweep,
        ),
        pytest.param("cat part.ngc | {t} plan /dev/stdin {p} -o out", marks=pytest.mark.sweep),
        pytest.param("{t} plan - {p} -o out < part.ngc", marks=pytest.mark.sweep),
        pytest.param("mkfifo pipe; cat part.ngc > pipe & {t} plan pipe {p} -o out", marks=pytest.mark.sweep),
    ],
    ids=["hyphen", "substitution", "/dev/stdin", "redirected", "fifo"],
)
def test_a_program_from_a_pipe_is_planned_and_kept(here, command, blade):
    done = shell(command.format(t=TOOLPACE, p=" ".join(PLAN)))
    assert done.returncode == 0 and done.stderr == ""
    plan = json.loads((here / "out" / "plan.json").read_text())
    assert (here / "out" / plan["program_file"]).read_text() == blade
    assert main(["verify", "out"]) == 0


def test_what_is_kept_is_what_was_planned(here, monkeypatch, blade):
    """A program that changes while it is planned, and a machine file too."""
    from toolpace.jobs import plan_steps

    text = Machine.load("xyzac-trunnion").to_toml()
    (here / "mill.toml").write_text(text)
    plan_motion = plan_steps.plan_motion

    def slow(*given):
        (here / "part.ngc").write_text("G0 X0 Y0 Z0\nG1 X1 F1\nM30\n")
        (here / "mill.toml").write_text("nonsense")
        return plan_motion(*given)

    monkeypatch.setattr(plan_steps, "plan_motion", slow)
    assert main(["plan", "part.ngc", "-m", "mill.toml", "--no-report", "-o", "out"]) == 0
    assert (here / "out" / "program.ngc").read_text() == blade and (here / "out" / "machine.toml").read_text() == text
    assert main(["verify", "out"]) == 0


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("redirect", "code", "says"),
    [
        ("| head -1", 0, ""),
        pytest.param(">&-", 0, "", marks=pytest.mark.sweep),
        pytest.param("> /dev/full", 2, "standard output: cannot write: no space left", marks=pytest.mark.sweep),
    ],
    ids=["head", "closed", "full"],
)
def test_a_plan_is_written_also_where_nobody_reads_what_is_said(here, redirect, code, says):
    done = shell(f"set -o pipefail; {TOOLPACE} plan part.ngc {' '.join(PLAN)} -o out {redirect}")
    assert done.returncode == code and says in done.stderr and done.stderr.count("\n") == (code > 0)
    assert foreign(here / "out") == "" and (here / "out" / "plan.json").exists()


@pytest.mark.sweep
def test_output_to_a_full_disk_and_letters_it_does_not_know(here):
    full = "error: standard output: cannot write: no space left on device\n"
    for command, redirect, code, says in (
        ("machines", "> /dev/full", 2, full), ("--help", "> /dev/full", 2, full), ("machines", ">&-", 0, ""),
        ("machines", "2>&- > /dev/full", 2, ""),
    ):  # fmt: skip
        done = shell(f"{TOOLPACE} {command} {redirect}")
        assert (done.returncode, done.stderr) == (code, says), command
    done = shell(f"{TOOLPACE} machines xyzac-trunnion", env=os.environ | {"PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0 and done.stderr == "" and "mm/s" in done.stdout


SIGNALLED = """
import os, signal, sys
from toolpace.cli import main
from toolpace.jobs import plan_steps

number, plan_motion = int(sys.argv[1]), plan_steps.plan_motion
if number == signal.SIGHUP:
    signal.signal(number, signal.SIG_DFL)  # under nohup it is ignored, also by children

def hit(*given):
    os.kill(os.getpid(), number)
    return plan_motion(*given)

plan_steps.plan_motion = hit
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.sweep
@pytest.mark.parametrize(
    "number",
    [signal.SIGTERM, *(pytest.param(number, marks=pytest.mark.sweep) for number in (signal.SIGINT, signal.SIGHUP))],
)
def test_a_signal_leaves_the_old_plan_and_nothing_else(here, number):
    assert main(["plan", "part.ngc", *PLAN, "-o", "out"]) == 0
    before = content(here)
    command = [sys.executable, "-c", SIGNALLED, str(int(number)), "plan", "part.ngc", *PLAN, "-o", "out", "--csv"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    word = "interrupted" if number == signal.SIGINT else "ended from outside"
    assert done.stderr == f"error: {word}; nothing was written\n" and done.returncode == 128 + number
    assert content(here) == before


def test_an_interrupt_after_the_writing_does_not_say_that_nothing_was_written(here, monkeypatch, capsys):
    from toolpace.cli import summary

    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(summary, "show_plan", interrupted)
    assert main(["plan", "part.ngc", *PLAN, "-o", "out"]) == 130
    assert capsys.readouterr().err == f"error: interrupted; {here / 'out'} had been written, and is whole\n"
    assert foreign(here / "out") == ""


@pytest.mark.sweep
def test_names_are_no_markup_and_move_no_cursor(here, capsys):
    text = Machine.load("xyzac-trunnion").to_toml().replace('"xyzac-trunnion"', '"[/b]mill"')
    (here / "[red].toml").write_text(text)
    odd = ("[b]x", "\x1b[31mred\x07", "two\nlines", "\u202eright to left", "\udcff")
    for name in odd:
        (here / f"{name}.ngc").write_bytes((here / "part.ngc").read_bytes())
        assert main(["plan", f"{name}.ngc", "-m", "[red].toml", "--no-report", "-o", f"[/b]/{name}"]) == 0
        output = capsys.readouterr().out
        assert all(line.isprintable() for line in output.splitlines()) and "[/b]mill" in output
        plan = (here / "[" / "b]" / name / "plan.json").read_text(encoding="utf-8")
        assert all(line.isprintable() for line in plan.splitlines())
        assert main(["verify", f"[/b]/{name}"]) == 0
        assert all(line.isprintable() for line in capsys.readouterr().out.splitlines())
        refused(capsys, ["plan", f"{name}-missing.ngc", "-m", "paper-ab"])


ARGUMENTS = {
    "feed too slow": (["--feed", "1e-300mm/min"], "below 1e-06 mm/min"),
    "feed too fast": (["--feed", "1e300mm/min"], "--feed none"),
    "factor": (["--feed", "1e-300%"], "between 0.0001%"),
    "number too large": (["--feed", "1e400mm/min"], "finite"),
    "number too long": (["--feed", "9" * 5000 + "mm/min"], "finite"),
    "blanks": (["--feed", "1" + " " * 100_000 + "x y"], "is not a feed"),
    "cursor": (["--feed", "\x1b[2j"], r"'\x1b[2j' is not a feed"),
    "time step too small": (["--dt", "1e-300s"], "give a value from"),
    "time step too long": (["--dt", "1e300s"], "give a value from"),
    "no memory": (["--dt", "0.002us"], "GB are free"),
    "tip tolerance": (["--tip-tolerance", "1e-300mm"], "give a value from"),
    "tip tolerance too large": (["--tip-tolerance", "1e300mm"], "give a value from"),
    "axis tolerance": (["--axis-tolerance", "1e300deg"], "give a value from"),
    "tool": (["--tool-length", "1e300mm"], "tool length is 1e+297, beyond 4"),
    "a planner's long name": (["--planner", "x" * 100_000], "unknown planner"),
    "a long dialect": (["--dialect", "x" * 100_000], "use gcode, apt or csv"),
}


@pytest.mark.parametrize("case", ARGUMENTS)
def test_arguments_beyond_all_bounds_are_one_line_before_the_work(here, capsys, monkeypatch, case):
    from toolpace.jobs import plan_steps

    monkeypatch.setattr(plan_steps, "fit_path", lambda *given: pytest.fail("the work had begun"))
    if case == "no memory":
        monkeypatch.setattr("toolpace.motion.setpoints.free_memory", lambda: 1e9)
    given, says = ARGUMENTS[case]
    began = time.process_time()
    error = refused(capsys, ["plan", "part.ngc", *PLAN, "-o", "out", *given], says)
    assert len(error) < 1100 and time.process_time() - began < 20.0
    assert not (here / "out").exists()


def test_results_that_would_not_fit_are_refused_before_the_work(here, capsys, monkeypatch):
    monkeypatch.setattr("toolpace.common.files.free_disk", lambda folder: 1e5)
    refused(capsys, ["plan", "part.ngc", *PLAN, "-o", "out"], "the results take more than", "are free there")
    assert sorted(names(here)) == ["part.ngc"]


PROGRAMS = {
    "/dev/full": "binary", "/dev/null": "empty", "/dev/zero": "binary", ".": "folder", "nul\0": "null byte",
    "x" * 5000: "cannot be opened", "\udcff": "no such file",
}  # fmt: skip


@pytest.mark.parametrize("program", PROGRAMS)
def test_programs_that_are_none(here, capsys, program):
    refused(capsys, ["plan", program, *PLAN, "-o", "out"], PROGRAMS[program])


@pytest.mark.parametrize("where", ["verify", "machines"])
@pytest.mark.parametrize("name", ["x" * 5000, "\x1b", "nul\0", "/dev/null", "\udcff"])
def test_folders_and_machines_that_are_none(here, capsys, where, name):
    refused(capsys, [where, name])


@pytest.mark.sweep
def test_damaged_results_are_one_line(here, capsys):
    assert main(["plan", "part.ngc", *PLAN, "-o", "out"]) == 0
    capsys.readouterr()
    plan, points = here / "out" / "plan.json", here / "out" / "setpoints.npz"
    good, told = plan.read_bytes(), json.loads(plan.read_bytes())
    deep = good.replace(b'"usage": {', b'"x": ' + b"[" * 50_000 + b"]" * 50_000 + b',"usage": {')
    bad = [deep, b"[" * 100_000, b"\0" * 100, b"", good.replace(b'"dt_s": 0.001', b'"dt_s": 1e400')]
    for data in [*bad, good.decode().encode("utf-16"), json.dumps(told | {"feed": "\x1b"}).encode()]:
        plan.write_bytes(data)
        refused(capsys, ["verify", "out"])
    plan.unlink()
    plan.symlink_to("/dev/zero")
    refused(capsys, ["verify", "out"], "is a pipe or a device")
    plan.unlink()
    plan.write_bytes(b" " * (64 << 20) + b"{}")
    refused(capsys, ["verify", "out"], "more than 64 MB")
    plan.unlink()
    plan.mkdir()
    refused(capsys, ["verify", "out"], "is a directory")
    plan.rmdir()
    plan.write_bytes(good)
    arrays = dict(np.load(points))
    for changes in ({"q": arrays["q"] * 1j}, {"t": np.float64(1.0)}, {"joints": arrays["joints"][:1]}):
        np.savez(points, **(arrays | changes))
        refused(capsys, ["verify", "out"], "setpoints.npz")
    np.savez(points, **(arrays | {"joints": np.array(["\x1b[31m", "Y", "Z", "A", "C"]), "q": arrays["q"] * 1e9}))
    assert main(["verify", "out"]) == 1
    output = capsys.readouterr()
    assert output.err == "" and all(line.isprintable() for line in output.out.splitlines())


KILLED = """
import os, signal, sys, threading, time
from toolpace.cli import main

threading.Timer(float(sys.argv[1]), lambda: os.kill(os.getpid(), signal.SIGKILL)).start()
main(sys.argv[2:])
"""


@pytest.mark.parametrize(
    "kills", [pytest.param(3, marks=pytest.mark.sweep), pytest.param(40, marks=pytest.mark.thorough)]
)
def test_the_whole_command_killed_over_an_old_result(here, kills):
    """Some tens of times, at instants spread over its run; the folder is always whole, and the next run sweeps up."""
    assert main(["plan", "part.ngc", *PLAN, "-o", "out"]) == 0
    began = time.perf_counter()
    assert shell(f"{TOOLPACE} plan part.ngc {' '.join(PLAN)} -o out").returncode == 0
    whole = time.perf_counter() - began
    chance = np.random.default_rng(20261122)
    for _ in range(kills):
        command = [sys.executable, "-c", KILLED, str(chance.uniform(0.2, 1.1) * whole), "plan", "part.ngc", *PLAN]
        subprocess.run([*command, "-o", "out"], capture_output=True, timeout=600)
        assert foreign(here / "out") == "" and set(content(here / "out")) == RESULTS | {"program.ngc"}
        assert main(["verify", "out"]) == 0
        left = [name for name in names(here) if name not in ("out", "part.ngc")]
        assert len(left) <= 1 and all(name.startswith(".toolpace-new-") for name in left)
    assert main(["plan", "part.ngc", *PLAN, "-o", "out"]) == 0
    assert sorted(names(here)) == ["out", "part.ngc"]
