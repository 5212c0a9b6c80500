"""The cache of compiled kernels: damaged files, folders that cannot be used, processes side by side."""

from __future__ import annotations

import errno
import functools
import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from toolpace.kernels import kernel_cache as kept
from toolpace.kernels.kernel_cache import COMPLETE, DIGEST, SUFFIX, UNUSED, Store

SOURCES = Path(kept.__file__).parent

FORWARD = """
import toolpace as tp
machine = tp.Machine.load("xyzac-trunnion")
tip, axis = machine.forward([[0.01, 0.02, 0.03, 0.4, 0.5]])
from toolpace.kernels.jit import KERNELS
stats = KERNELS["kinematics.chain.forward"].stats
print(tip.tobytes().hex(), sum(stats.cache_hits.values()))
"""
"""Calls one kernel; prints its result, and how often its code was found."""


@pytest.fixture(autouse=True)
def fresh(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No folder is chosen yet, nothing has been warned of; nor are they after the test."""
    monkeypatch.setattr(kept, "_warned", functools.cache(list))
    kept.store.cache_clear()
    yield
    kept.store.cache_clear()


def environment(**folders: Path) -> dict[str, str]:
    plain = {name: value for name, value in os.environ.items() if name not in ("TOOLPACE_CACHE", "XDG_CACHE_HOME")}
    return plain | {name: str(folder) for name, folder in folders.items()}


def forward(**folders: Path) -> tuple[str, int, list[str]]:
    """Result, times the code was found, and lines on standard error of a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", FORWARD], capture_output=True, text=True, timeout=600, env=environment(**folders)
    )
    assert done.returncode == 0, done.stderr
    result, found = done.stdout.split()
    return result, int(found), done.stderr.splitlines()


def kernel_files(folder: Path) -> list[Path]:
    return sorted(folder.rglob(f"*{SUFFIX}"))


def test_what_is_saved_is_loaded(tmp_path):
    store = Store(tmp_path / "deep" / "folder")
    assert store.load("a.kernel") is None
    store.save("a.kernel", b"machine code")
    assert store.load("a.kernel") == b"machine code"
    assert list(store.files()) == ["a.kernel"]


CUTS = [lambda c: c[:-1], lambda c: c[: DIGEST // 2], lambda c: b"", lambda c: c[:-1] + b"?"]


@pytest.mark.parametrize("damage", CUTS)
def test_a_damaged_file_is_told_once_and_made_anew(tmp_path, capsys, damage):
    store = Store(tmp_path)
    for name in ("a.kernel", "b.kernel"):
        store.save(name, b"machine code")
        (tmp_path / name).write_bytes(damage((tmp_path / name).read_bytes()))
        assert store.load(name) is None
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.startswith("warning: ") and "a.kernel" in said
    store.save("a.kernel", b"machine code")
    assert store.load("a.kernel") == b"machine code"


def test_a_full_disk_is_told_once_and_done_without(tmp_path, capsys, monkeypatch):
    def full(self: Path, data: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    store = Store(tmp_path)
    store.save("before.kernel", b"kept")
    monkeypatch.setattr(Path, "write_bytes", full)
    store.save("a.kernel", b"machine code")
    store.save("b.kernel", b"machine code")
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "no space left on device" in said
    assert store.load("a.kernel") is None and [each.name for each in tmp_path.iterdir()] == ["before.kernel"]
    assert store.load("before.kernel") == b"kept"  # what was kept serves on


def test_complete_until_something_is_gone_or_cut(tmp_path):
    store = Store(tmp_path)
    assert not store.complete()
    store.save("a.kernel", b"first")
    store.save("b.kernel", b"second")
    store.mark_complete()
    assert store.complete()
    store.save("c.kernel", b"a later one does no harm")
    assert store.complete()
    (tmp_path / "a.kernel").write_bytes(b"cut")
    assert not store.complete()
    store.mark_complete()
    (tmp_path / "b.kernel").unlink()
    assert not store.complete()
    (tmp_path / COMPLETE).write_bytes(b"\xff\x00")
    assert not store.complete()


def test_folders_of_other_sources_go_when_unused_for_long(tmp_path):
    def folder(name: str, age: float) -> Path:
        made = tmp_path / name
        made.mkdir()
        (made / "a.kernel").write_bytes(b"machine code")
        then = made.stat().st_mtime - age
        os.utime(made, (then, then))
        return made

    old, recent = folder("0123456789abcdef", 2.0 * UNUSED), folder("fedcba9876543210", 0.5 * UNUSED)
    other = folder("somebody's own", 2.0 * UNUSED)
    now = Store(folder("00000000ffffffff", 2.0 * UNUSED))
    now.mark_complete()
    assert not old.exists() and recent.exists() and other.exists() and now.complete()


def test_folders_are_tried_in_order(tmp_path, monkeypatch, capsys):
    for name in ("TOOLPACE_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.setenv(name, str(tmp_path / name))
    assert kept.bases() == [tmp_path / "TOOLPACE_CACHE", tmp_path / "XDG_CACHE_HOME", tmp_path / "HOME" / ".cache"]
    assert kept.store().folder == tmp_path / "TOOLPACE_CACHE" / "toolpace" / kept.key()
    assert capsys.readouterr().err == ""
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("TOOLPACE_CACHE", str(tmp_path / "file" / "below"))
    kept.store.cache_clear()
    assert kept.store().folder == tmp_path / "XDG_CACHE_HOME" / "toolpace" / kept.key()
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "not a directory" in said and str(tmp_path / "XDG_CACHE_HOME") in said


def test_a_complete_folder_need_not_be_writable(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TOOLPACE_CACHE", str(tmp_path))
    made = Store(tmp_path / "toolpace" / kept.key())
    made.save("a.kernel", b"machine code")
    made.mark_complete()
    monkeypatch.setattr(kept, "_why_unusable", lambda folder: "read-only file system")
    assert kept.store().folder == made.folder and capsys.readouterr().err == ""


def test_without_any_folder_a_temporary_one_serves_the_process(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("in the way")
    for name in ("TOOLPACE_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.setenv(name, str(tmp_path / "file" / name))
    store = kept.store()
    assert not store.kept and store.folder is not None
    store.save("a.kernel", b"machine code")
    assert store.load("a.kernel") == b"machine code"
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.startswith("warning: ")
    kept._remove(store.folder.parent.parent, os.getpid())
    assert not store.folder.parent.parent.exists()


@pytest.mark.sweep
def test_a_kernel_is_compiled_once_and_again_where_its_file_is_cut(tmp_path):
    first, found, said = forward(TOOLPACE_CACHE=tmp_path)
    assert found == 0 and said == []
    again, found, said = forward(TOOLPACE_CACHE=tmp_path)
    assert again == first and found == 1 and said == []
    for file in kernel_files(tmp_path):
        file.write_bytes(file.read_bytes()[:1000])
    cut, found, said = forward(TOOLPACE_CACHE=tmp_path)
    assert cut == first and found == 0
    assert len(said) == 1 and said[0].startswith("warning: ")
    healed, found, said = forward(TOOLPACE_CACHE=tmp_path)
    assert healed == first and found == 1 and said == []


@pytest.mark.sweep
def test_where_nothing_can_be_written_nothing_lies_beside_the_sources(tmp_path):
    before = {each for each in SOURCES.rglob("*") if each.suffix in (".nbi", ".nbc", SUFFIX)}
    (tmp_path / "file").write_text("in the way")
    way = tmp_path / "file" / "below"
    _, _, said = forward(TOOLPACE_CACHE=way, XDG_CACHE_HOME=way, HOME=way)
    assert len(said) == 1 and said[0].startswith("warning: compiled kernels cannot be kept in ")
    assert {each for each in SOURCES.rglob("*") if each.suffix in (".nbi", ".nbc", SUFFIX)} == before


@pytest.mark.sweep
def test_processes_side_by_side_on_an_empty_cache_leave_it_whole(tmp_path):
    command = [sys.executable, "-c", FORWARD]
    started = [
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment(TOOLPACE_CACHE=tmp_path))
        for _ in range(4)
    ]
    results = {each.communicate(timeout=600)[0].split()[0] for each in started}
    assert len(results) == 1 and all(each.returncode == 0 for each in started)
    for file in kernel_files(tmp_path):
        content = file.read_bytes()
        assert hashlib.sha256(content[DIGEST:]).digest() == content[:DIGEST]
    assert [each for each in tmp_path.rglob("*.*") if each.is_file() and each.suffix != SUFFIX] == []
