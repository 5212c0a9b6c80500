"""Batches in this process: every job ends with a row and, where it can, a folder; what is done is not done again."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import toolpace as tp
from toolpace.cli import demo_programs, main
from toolpace.common.errors import UsageError
from toolpace.jobs.batch import estimate
from toolpace.jobs.batch.folder import batch_folder, batch_page
from toolpace.jobs.batch.job import BatchJob, BatchRow, Loader

MACHINE = "xyzac-trunnion"
BAD = "G21 G90 G54\nG43.4 H1\nG1 X1 Y2 F100\nG900 X4\nM30\n"


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """Three programs, one of which is refused, and a file that is none."""
    folder = tmp_path_factory.mktemp("batch") / "parts"
    folder.mkdir()
    (folder / "one.ngc").write_text(demo_programs.spiral_program(40))
    (folder / "two.ngc").write_text(demo_programs.spiral_program(60))
    (folder / "bad.ngc").write_text(BAD)
    (folder / "notes.pdf").write_bytes(b"%PDF")
    return folder


@pytest.fixture(scope="module")
def done(parts):
    """A batch of them, with its output."""
    out = parts.parent / "out"
    return out, main(["batch", str(parts), "-m", MACHINE, "-o", str(out), "--workers", "0", "--no-report"])


def table(out: Path) -> dict[str, dict]:
    rows = json.loads((out / "batch.json").read_text())["jobs"]
    return {Path(row["program"]).name: row for row in rows}


@pytest.mark.sweep
def test_a_bad_program_stops_no_other_and_is_told_in_its_row(done):
    out, code = done
    rows = table(out)
    assert code == 2 and set(rows) == {"one.ngc", "two.ngc", "bad.ngc"}
    assert rows["bad.ngc"]["verdict"] == "error" and "bad.ngc:4: G900 is not read" in rows["bad.ngc"]["error"]
    for name in ("one.ngc", "two.ngc"):
        row = rows[name]
        plan = json.loads((out / row["folder"] / "plan.json").read_text())
        assert row["verdict"] == "verified" and row["folder"].startswith(Path(name).stem + "-")
        assert (row["duration_s"], row["gap"]) == (plan["duration_s"], plan["gap"]) and row["machine"] == MACHINE
        assert main(["verify", str(out / row["folder"])]) == 0


def test_the_tables_have_a_row_a_job(done):
    pq = pytest.importorskip("pyarrow.parquet")
    out, _ = done
    found = pq.read_table(out / "batch.parquet").to_pydict()
    rows = list(table(out).values())
    assert found["program"] == [row["program"] for row in rows] and found["duration_s"] == [
        row["duration_s"] for row in rows
    ]
    page = (out / "batch.html").read_text()
    assert page.count("<tr>") == 1 + len(rows) and "Content-Security-Policy" in page
    for row in rows:
        assert f'href="{row["folder"]}/plan.json"' in page or not row["folder"]


def test_rows_lead_to_what_is_there(done, tmp_path):
    out, _ = done
    rows = [msgspec.convert(row, BatchRow) for row in table(out).values()]
    assert "<a href=" not in batch_page(tmp_path, rows)
    there = next(row.folder for row in rows if row.folder)
    (tmp_path / there).mkdir()
    (tmp_path / there / "plan.json").touch()
    assert batch_page(tmp_path, rows).count("<a href=") == 1


def test_the_same_command_again_does_only_what_is_not_done(done, parts):
    out, _ = done
    before = {path: path.stat().st_mtime_ns for path in out.glob("*/plan.json")}
    assert main(["batch", str(parts), "-m", MACHINE, "-o", str(out), "--workers", "0", "--no-report"]) == 2
    assert {path: path.stat().st_mtime_ns for path in out.glob("*/plan.json")} == before and len(before) == 2
    assert {name: row["found"] for name, row in table(out).items()} == {
        "one.ngc": True,
        "two.ngc": True,
        "bad.ngc": False,
    }


def test_a_folder_that_was_changed_is_not_taken_for_done_nor_replaced(parts, tmp_path):
    job = BatchJob(program=parts / "one.ngc", machine=MACHINE, report=False)
    row = tp.batch([job], tmp_path / "out", 0).rows[0]
    plan = tmp_path / "out" / row.folder / "plan.json"
    plan.write_text(plan.read_text().replace('"stops": 0', '"stops": 1'))
    again = tp.batch([job], tmp_path / "out", 0)
    assert again.exit_code == 2 and "plan.json is not as toolpace wrote it" in again.rows[0].error


def test_two_jobs_that_ask_for_the_same_are_done_once(parts, tmp_path):
    jobs = [
        BatchJob(program=parts / "one.ngc", machine=machine, what="time", optimum=False)
        for machine in (MACHINE, MACHINE)
    ]
    ended = []
    done = tp.batch(jobs, tmp_path / "out", 0, progress=lambda row, count: ended.append(count))
    assert [row.verdict for row in done] == ["timed", "timed"] and done.rows[0].folder == done.rows[1].folder
    assert ended == [1, 2] and len(list((tmp_path / "out").glob("*/time.json"))) == 1
    assert done.ok and done.exit_code == 0


def test_inspect_time_and_export(parts, tmp_path, capsys):
    words = ["--workers", "0", "--no-report"]
    assert main(["batch", str(parts), "--what", "inspect", "-o", str(tmp_path / "inspected"), *words]) == 2
    rows = table(tmp_path / "inspected")
    assert MACHINE in rows["one.ngc"]["machine"] and rows["one.ngc"]["verdict"] == "read"
    assert rows["bad.ngc"]["error"].startswith("G900 (line 4): ")
    assert main(["batch", str(parts / "one.ngc"), "-m", MACHINE, "--what", "export", "--to", "table", "-o",
                 str(tmp_path / "exported"), *words]) == 0  # fmt: skip
    row = table(tmp_path / "exported")["one.ngc"]
    assert (tmp_path / "exported" / row["exported"] / "table.csv").exists() and row["verdict"] == "verified"
    assert (
        main(["batch", str(parts / "one.ngc"), "-m", MACHINE, "--what", "time", "-o", str(tmp_path / "timed"), *words])
        == 0
    )
    row = table(tmp_path / "timed")["one.ngc"]
    # the program's own tolerance, or its control's
    assert row["tip_tolerance_mm"] is None and row["axis_tolerance_deg"] is None
    assert row["duration_s"] > row["optimum_s"] > 0.0
    for what in ("inspected", "exported", "timed"):
        capsys.readouterr()
        options = {"inspected": ["--what", "inspect"], "exported": ["--what", "export", "--to", "table", "-m", MACHINE],
                   "timed": ["--what", "time", "-m", MACHINE]}[what]  # fmt: skip
        main(["batch", str(parts / "one.ngc"), "-o", str(tmp_path / what), *options, *words])
        assert "1 of 1 job, 1 of them by an earlier batch" in capsys.readouterr().out


def test_a_failed_verification_is_1(parts, tmp_path):
    job = BatchJob(program=parts / "one.ngc", machine=MACHINE, planner="second-order", report=False)
    done = tp.batch([job], tmp_path / "out", 0)
    assert [row.verdict for row in done] == ["failed"] and done.exit_code == 1 and not done.ok


def test_what_a_job_depends_on_changes_its_key(parts, tmp_path):
    slower = tmp_path / "slower.toml"
    slower.write_text(tp.Machine.load(MACHINE).to_toml().replace("jerk = ", "jerk = 0.5e0 #", 1))
    other = tmp_path / "one.ngc"
    other.write_text((parts / "one.ngc").read_text() + "(end)\n")
    sheet = tmp_path / "setup.toml"
    sheet.write_text("[offsets.G54]\nX = 1.0\n")
    job = BatchJob(program=parts / "one.ngc", machine=MACHINE)
    changes = [
        {"program": other}, {"program": parts / "two.ngc"}, {"machine": str(slower)}, {"machine": "xyzac-head"},
        {"what": "time"}, {"what": "export", "to": "table"}, {"tip_tolerance": 2e-5}, {"axis_tolerance": 1e-3},
        {"planner": "genetic"}, {"effort": "low"}, {"prove_within": 5.0}, {"feed": "120%"}, {"tool_length": 0.1},
        {"dt": 2e-3},
        {"csv": True}, {"npz": False}, {"report": False}, {"dialect": "gcode"}, {"controller": "fanuc"},
        {"setup": str(sheet)}, {"skip_unknown": True}, {"compensation": "program"}, {"max_blocks": 10},
    ]  # fmt: skip
    loader = Loader()
    keys = [loader.prepare(each).key for each in (job, *(dataclasses.replace(job, **change) for change in changes))]
    assert len(set(keys)) == len(changes) + 1
    assert Loader().prepare(job).key == keys[0]


def test_the_estimate_of_memory_grows_with_the_program(parts):
    loader = Loader()
    small, large = (BatchJob(program=parts / name, machine=MACHINE) for name in ("one.ngc", "two.ngc"))
    assert 3e8 < estimate(loader.prepare(small)) < estimate(loader.prepare(large)) < 4e8


def test_a_folder_with_anything_else_in_it_is_refused(tmp_path, parts, capsys):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    assert main(["batch", str(parts), "-m", MACHINE, "-o", str(tmp_path / "mine"), "--workers", "0"]) == 2
    assert "is not empty, and no batch was written there" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["letter.txt"]


def test_two_batches_do_not_write_into_one_folder(tmp_path):
    told = pytest.raises(UsageError, match="another batch writes there now")
    with batch_folder(tmp_path / "out"), told, batch_folder(tmp_path / "out"):
        pass
    with batch_folder(tmp_path / "out"):
        pass


@pytest.mark.sweep
def test_a_disk_that_is_full_is_told_in_the_row(parts, tmp_path):
    """The largest file that the process may write is smaller than set-points are."""
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000));"
        "from toolpace.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    words = ["batch", str(parts / "one.ngc"), str(parts / "bad.ngc"), "-m", MACHINE, "--workers", "0", "--no-report"]
    done = subprocess.run([sys.executable, "-c", code, *words, "-o", str(tmp_path / "out")], timeout=120)
    rows = table(tmp_path / "out")
    assert done.returncode == 2 and rows["one.ngc"]["error"].endswith("cannot write: file too large")
    assert rows["bad.ngc"]["verdict"] == "error" and not list((tmp_path / "out").glob("one*"))
    again = tp.batch([BatchJob(program=parts / "one.ngc", machine=MACHINE, report=False)], tmp_path / "out", 0)
    assert again.ok and not again.rows[0].found


@pytest.mark.parametrize(
    "words, message",
    [
        (["parts/*.nothing", "-m", MACHINE], "no program is there"),
        (["one.ngc"], "--machine is missing"),
        (["one.ngc", "-m", MACHINE, "--what", "paint"], "what = 'paint' is not known; did you mean 'plan'?"),
        (["one.ngc", "-m", MACHINE, "--what", "export"], "goes with `to`, the target"),
        (["one.ngc", "-m", MACHINE, "--what", "export", "--to", "tables"], "did you mean 'table'?"),
        (["one.ngc", "-m", MACHINE, "--cluster", "tcp://127.0.0.1:9", "--workers", "2"], "one of them"),
        (["one.ngc", "-m", MACHINE, "--workers", "-1"], "--workers -1: give 1 or more"),
        (["one.ngc", "-m", MACHINE, "--tip-tolerance", "1mm", "--tip-tolerance", "0mm"], "--tip-tolerance 0mm"),
        (["one.ngc", "jobs.toml"], "names all programs itself; give it alone"),
        (["jobs.toml", "-m", MACHINE], "stands in the file"),
        (["jobs.toml"], "file of jobs jobs.toml: cannot be read"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_told_in_one_line(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["batch", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and not list(tmp_path.iterdir())
