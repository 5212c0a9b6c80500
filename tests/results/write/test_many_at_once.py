"""Many runs at once, in one folder and in one place: none takes anything from another, and none fails for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from toolpace.common.files import atomic, seal, whole_folder
from toolpace.common.files.atomic import Temporary, held, sweep

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no locks")


@pytest.mark.parametrize("places", [1, 3])
def test_many_processes_write_side_by_side(tmp_path, places):
    done = subprocess.run(
        [sys.executable, "-m", "tests.results.write.many", str(tmp_path), "8", "30", str(places)],
        capture_output=True, text=True, timeout=300, cwd=ROOT, env=os.environ | {"PYTHONPATH": f"{ROOT}/src:{ROOT}"},
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout + done.stderr)[-2000:]


@pytest.mark.parametrize("moment", ["before the lock", "with the lock"])
def test_a_name_that_is_swept_before_it_is_locked_is_made_anew(tmp_path, monkeypatch, moment):
    """Whoever cleans up takes a name without a lock for that of a dead run."""
    lock, names = atomic._locked, []

    def late(path):
        monkeypatch.setattr(atomic, "_locked", lock)
        names.append(path)
        sweep(tmp_path / "other")
        assert not path.exists()
        if moment == "with the lock":
            raise BlockingIOError
        return lock(path)

    monkeypatch.setattr(atomic, "_locked", late)
    made = Temporary(tmp_path / "out", folder=True)
    assert made.path.is_dir() and made.path != names[0]
    sweep(tmp_path / "other")
    assert made.path.is_dir()
    made.remove()
    assert list(tmp_path.iterdir()) == []


def test_what_is_held_is_neither_swept_nor_held_twice(tmp_path, monkeypatch):
    monkeypatch.setattr(atomic, "PATIENCE", 0.05)
    moved = tmp_path / "out"
    with whole_folder(moved, seal="plan.json") as folder:
        (folder / "plan.json").write_text('{"a": 1\n}\n')
    with held(moved):
        with pytest.raises(BlockingIOError):
            atomic._locked(moved)
        away = moved.rename(atomic.temporary_name(moved))
        sweep(moved)
        assert away.is_dir()
        with held(away):
            assert away.is_dir()
    sweep(moved)
    assert not away.exists()
    with held(tmp_path / "missing"):
        assert list(tmp_path.iterdir()) == []


def test_a_folder_that_another_run_replaces_meanwhile_is_not_said_to_be_changed(tmp_path, monkeypatch):
    """The seal of the one, and the files of the other: as between two looks at a folder."""
    for name in ("old", "new"):
        with whole_folder(tmp_path / name, seal="plan.json") as folder:
            (folder / "plan.json").write_text('{"a": 1\n}\n')
            (folder / "data.bin").write_bytes(name.encode())
    read, out = seal.read_seal, tmp_path / "old"

    def replaced_behind_it(folder):
        found = read(folder)
        if (tmp_path / "new").exists():
            out.rename(tmp_path / "away")
            (tmp_path / "new").rename(out)
        return found

    monkeypatch.setattr(seal, "read_seal", replaced_behind_it)
    assert seal.foreign(out) == ""
    (out / "data.bin").write_bytes(b"by hand")
    assert "data.bin was changed" in seal.foreign(out)
