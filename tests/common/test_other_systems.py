"""What other systems lack is hidden here: every command has a fallback, and its files are as they are elsewhere.

Hidden: locks on files and limits of a process (Windows), the exchange of two names in one step and the options of the
allocator (all but Linux), the cores that a process may use (Windows, macOS).
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

from toolpace.jobs.batch.folder import MARK, batch_folder
from toolpace.kernels import lock

HIDE = """
import ctypes, os, sys
hidden = sys.argv.pop(1).split(",")
for name in {"fcntl", "resource"} & set(hidden):
    sys.modules[name] = None
if "sched_getaffinity" in hidden:
    del os.sched_getaffinity
whole = ctypes.CDLL
class Library(whole):
    def __getattr__(self, name):
        if name in hidden:
            raise AttributeError(name)
        return super().__getattr__(name)
ctypes.CDLL = Library
"""
COMMAND = HIDE + "from toolpace.cli import main\nsys.exit(main(sys.argv[1:]))"
PROGRAM = "G21 G90 G54\nG43.4 H1\nG1 X10 Y0 Z10 A0 C0 F1000\nX20 Y5\nX30 Y5 A5\nX40 Y0\nM30\n"
ALL = "fcntl,resource,renameat2,sched_getaffinity,mallopt"


def run(hidden: str, code: str, *words: str) -> str:
    command = [sys.executable, "-c", code, hidden, *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return done.stdout


@pytest.mark.sweep
def test_a_plan_is_written_twice_and_verified(tmp_path):
    (tmp_path / "part.ngc").write_text(PROGRAM)
    out = tmp_path / "plan"
    for feed in ("F1000", "F500"):
        (tmp_path / "part.ngc").write_text(PROGRAM.replace("F1000", feed))
        run(ALL, COMMAND, "plan", str(tmp_path / "part.ngc"), "-m", "xyzac-trunnion", "--no-report", "-o", str(out))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["part.ngc", "plan"]
    assert "F500" in (out / "program.ngc").read_text()
    assert "VERIFIED" in run(ALL, COMMAND, "verify", str(out))


@pytest.mark.sweep
def test_the_set_points_are_those_of_this_system(tmp_path):
    found = set()
    for hidden in (ALL, ""):
        (tmp_path / "part.ngc").write_text(PROGRAM)
        out = tmp_path / f"plan-{len(hidden)}"
        run(hidden, COMMAND, "plan", str(tmp_path / "part.ngc"), "-m", "xyzac-trunnion", "--no-report", "-o", str(out))
        found.add(hashlib.sha256((out / "setpoints.npz").read_bytes()).hexdigest())
    assert len(found) == 1


@pytest.mark.sweep
def test_a_batch_runs_on_two_workers(tmp_path):
    """With `fcntl` and `resource`, which the library of the workers needs on all systems but Windows."""
    programs, out = tmp_path / "parts", tmp_path / "out"
    programs.mkdir()
    for feed in (500, 1000):
        (programs / f"part-{feed}.ngc").write_text(PROGRAM.replace("F1000", f"F{feed}"))
    guarded = "if __name__ == '__main__':\n" + "\n".join("    " + line for line in COMMAND.splitlines())
    words = ("batch", str(programs), "-m", "xyzac-trunnion", "--workers", "2", "-o", str(out))
    run("renameat2,sched_getaffinity,mallopt", guarded, *words)
    assert len(list(out.glob("part-*/plan.json"))) == 2


def test_a_folder_of_a_batch_is_made_where_nothing_can_be_locked(tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "_module", lambda name: None)
    with batch_folder(tmp_path / "out") as place:
        assert (Path(place.folder) / MARK).read_text() == place.token


def test_what_the_system_does_not_tell_has_a_value():
    code = HIDE + (
        "from toolpace.common.cluster.pool import keep_memory\n"
        "from toolpace.common.files.free_space import free_memory\n"
        "from toolpace.kernels.ahead_of_time import cores\n"
        "from toolpace.kernels.lock import FileLock\n"
        "from pathlib import Path\n"
        "import tempfile\n"
        "with tempfile.TemporaryDirectory() as folder, FileLock(Path(folder) / 'lock') as lock:\n"
        "    try:\n"
        "        lock.take()\n"
        "    except OSError as error:\n"
        "        print(keep_memory(), free_memory() > 1e6, cores() == os.cpu_count(), error)\n"
    )
    assert run(ALL, code) == "False True True this system knows no locks\n"
