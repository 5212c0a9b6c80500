"""A folder of results takes its place in one step, replaces only what toolpace wrote, and leaves nothing behind."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from toolpace.common.errors import UsageError
from toolpace.common.files import atomic, finished, folder, folder_to_write, whole_file, whole_folder
from toolpace.common.files.seal import foreign, read_seal

ROOT = Path(__file__).parents[3]

NOBODY = 65534


def write_result(out, text="new", *, more=()):
    with whole_folder(out, seal="plan.json") as new:
        (new / "data.bin").write_text(text)
        for name in more:
            (new / name).write_text(name)
        (new / "plan.json").write_text(json.dumps({"text": text}, indent=2))


def content(out):
    return {path.name: path.read_bytes() for path in out.iterdir()}


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder to work in that is not that of the results."""
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")
    return tmp_path


def test_what_toolpace_wrote_is_replaced_as_a_whole(here):
    out = here / "out"
    write_result(out, "old", more=["only-old"])
    assert foreign(out) == "" and read_seal(out)[0] == "plan.json"
    write_result(out, "new")
    assert set(content(out)) == {"data.bin", "plan.json"} and (out / "data.bin").read_text() == "new"
    assert json.loads((out / "plan.json").read_text())["text"] == "new"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]


def test_an_empty_folder_is_taken_and_parents_are_made(here):
    (here / "empty").mkdir(mode=0o750)
    write_result(here / "empty")
    write_result(here / "a" / "b" / "c")
    assert foreign(here / "empty") == foreign(here / "a" / "b" / "c") == ""


CHANGES = {
    "a file of one's own": (lambda out: (out / "notes.txt").write_text("mine"), r"holds notes\.txt, which toolpace"),
    "a hidden file": (lambda out: (out / ".notes").write_text("mine"), r"holds \.notes, which toolpace"),
    "a folder": (lambda out: (out / "photos").mkdir(), r"holds photos, which toolpace"),
    "a link": (lambda out: (out / "link").symlink_to("/"), r"holds link, which toolpace"),
    "a changed file": (lambda out: (out / "data.bin").write_text("mine"), r"data\.bin was changed after toolpace"),
    "a file that became a link": (
        lambda out: ((out / "data.bin").rename(out.parent / "moved"), (out / "data.bin").symlink_to("../moved")),
        r"data\.bin was changed",
    ),
    "a changed plan": (
        lambda out: (out / "plan.json").write_text((out / "plan.json").read_text().replace("old", "odd")),
        r"plan\.json is not as toolpace wrote it",
    ),
    "no plan": (lambda out: (out / "plan.json").unlink(), r"holds data\.bin, and no plan\.json of toolpace"),
    "a plan without a seal": (lambda out: (out / "plan.json").write_text("{}"), r"plan\.json is not as"),
    "a seal of nothing": (lambda out: (out / "plan.json").write_text('{"seal": {"files": 1, "sha256": ""}}'), "is not"),
    "a deep plan": (lambda out: (out / "plan.json").write_text("[" * 100_000), r"plan\.json is not as"),
}  # fmt: skip


@pytest.mark.parametrize("case", CHANGES)
def test_what_somebody_else_made_or_changed_is_never_touched(here, case):
    out = here / "out"
    write_result(out, "old")
    change, says = CHANGES[case]
    change(out)
    before = {path: path.lstat().st_mtime_ns for path in here.rglob("*")}
    with pytest.raises(UsageError, match=says):
        folder_to_write(out)
    with pytest.raises(UsageError, match=says):
        write_result(out)
    assert {path: path.lstat().st_mtime_ns for path in here.rglob("*")}.keys() == before.keys()
    assert not (out / "data.bin").exists() or (out / "data.bin").read_text() in ("old", "mine")


def test_a_file_put_in_at_the_last_moment_is_not_lost(here, monkeypatch):
    """After the last look, and before the folders change places."""
    out = here / "out"
    write_result(out, "old")
    swap = folder.exchange

    def slow(one, other):
        if not (out / "notes.txt").exists():
            (out / "notes.txt").write_text("mine")
        return swap(one, other)

    monkeypatch.setattr(folder, "exchange", slow)
    with pytest.raises(UsageError, match=r"holds notes\.txt"):
        write_result(out)
    assert (out / "notes.txt").read_text() == "mine" and (out / "data.bin").read_text() == "old"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]


PLACES = {
    "": "name of the folder is empty",
    ".": "the folder you are in",
    "..": "above the folder you are in",
    "/": "above the folder you are in",
    "~": "is your home folder",
    "file": "is a file; give a folder",
    "file/out": "part of this path is a file",
    "to-file": "is a file; give a folder",
    "circle": "circle|too many levels of symbolic links",
    "x" * 300: "cannot be written: file name too long",
    "/".join(["y" * 200] * 25): "cannot be written: file name too long",
    "nul\0": "null",
    "/proc/out": "cannot be written",
    "/sys/out": "cannot be written",
    "/dev/null": "is a file",
    "/dev": "is not replaced|disk is mounted",
}


@pytest.mark.parametrize("place", PLACES)
def test_places_that_are_none_are_refused_before_the_work(here, monkeypatch, place):
    home = here / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    Path("file").write_text("mine")
    Path("to-file").symlink_to("file")
    Path("circle").symlink_to("circle")
    before = sorted(here.rglob("*"))
    with pytest.raises(UsageError, match=PLACES[place]):
        folder_to_write(str(home) if place == "~" else place)
    assert sorted(here.rglob("*")) == before


@pytest.fixture
def locked(tmp_path_factory):
    """A folder that may not be written into, by somebody to whom that matters: root becomes nobody for a while."""
    root = os.geteuid() == 0
    folder = Path(tempfile.mkdtemp()) if root else tmp_path_factory.mktemp("locked")
    folder.chmod(0o555)
    if root:
        os.seteuid(NOBODY)
    yield folder
    if root:
        os.seteuid(0)
    folder.chmod(0o700)
    shutil.rmtree(folder)


def test_a_folder_that_cannot_be_written_into(locked):
    with pytest.raises(UsageError, match="permission denied"):
        folder_to_write(locked / "out")


def test_a_link_to_a_folder_stays_and_the_folder_is_replaced(here):
    write_result(here / "real", "old")
    (here / "link").symlink_to("real")
    write_result(here / "link", "new")
    assert (here / "link").is_symlink() and (here / "real" / "data.bin").read_text() == "new"
    (here / "theirs").mkdir()
    (here / "theirs" / "machine.toml").write_text("mine")
    (here / "other").symlink_to("theirs")
    with pytest.raises(UsageError, match=r"holds machine\.toml"):
        write_result(here / "other")
    assert content(here / "theirs") == {"machine.toml": b"mine"}


def test_parents_that_were_made_go_when_the_work_fails(here):
    with pytest.raises(RuntimeError), whole_folder(here / "a" / "b" / "out"):
        raise RuntimeError
    assert sorted(path.name for path in here.iterdir()) == ["cwd"]


def test_without_an_exchange_the_folders_are_renamed_one_after_the_other(here, monkeypatch):
    monkeypatch.setattr(folder, "exchange", lambda one, other: False)
    write_result(here / "out", "old")
    write_result(here / "out", "new")
    assert (here / "out" / "data.bin").read_text() == "new"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]
    (here / "out" / "notes.txt").write_text("mine")
    monkeypatch.setattr(folder, "_refuse_taken", lambda target, given: None)
    with pytest.raises(UsageError, match=r"notes\.txt"):
        write_result(here / "out", "newer")
    assert (here / "out" / "notes.txt").read_text() == "mine" and (here / "out" / "data.bin").read_text() == "new"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]


def test_what_was_moved_away_before_a_kill_comes_back(here, monkeypatch):
    """Without an exchange there is a moment in which neither is there."""
    write_result(here / "out", "old")
    (here / "out").rename(atomic.temporary_name(here / "out", "old"))
    assert folder_to_write(here / "out") and (here / "out" / "data.bin").read_text() == "old"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]


def test_an_exchange_that_fails_for_another_reason_is_an_error(here):
    (here / "one").mkdir()
    with pytest.raises(OSError) as caught:
        folder.exchange(here / "one", here / "missing")
    assert caught.value.errno == errno.ENOENT


def test_only_what_dead_runs_left_is_swept(here):
    dead = here / ".toolpace-new-0123abcd-0123abcd"
    dead.mkdir()
    (dead / "setpoints.npz").write_text("half")
    (here / ".toolpace-new-0123abcd-0123abce.html").write_text("half")
    kept = [here / ".toolpace-new-0123abcd-0123abcf", here / ".toolpace-notes", here / ".toolpace-new-x-y.txt"]
    kept[0].mkdir()
    (kept[0] / "folder").mkdir()
    for path in kept[1:]:
        path.write_text("mine")
    with whole_folder(here / "other"), whole_file(here / "single.txt") as single:
        alive = set(here.glob(".toolpace-*")) - {dead, *kept}
        assert single in alive and len(alive) == 2
        folder_to_write(here / "out")
        assert not dead.exists() and all(path.exists() for path in [*kept, *alive])
        single.write_text("whole")
    assert sorted(path.name for path in here.iterdir()) == sorted(
        ["cwd", "other", "single.txt", *(path.name for path in kept)]
    )


def test_two_runs_at_once_end_with_one_of_both(here):
    with whole_folder(here / "out", seal="plan.json") as first, whole_folder(here / "out", seal="plan.json") as second:
        for name, each in (("first", first), ("second", second)):
            (each / "data.bin").write_text(name)
            (each / "plan.json").write_text("{\n}\n".replace("{", '{"a": 1'))
    assert (here / "out" / "data.bin").read_text() == "first"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_the_folder_is_put_in_place_waits_for_it(here, monkeypatch, number):
    """The word that follows, that something was written, is then true."""
    swap = folder.exchange

    def signalled(one, other):
        os.kill(os.getpid(), number)
        return swap(one, other)

    write_result(here / "out", "old")
    finished.clear()
    monkeypatch.setattr(folder, "exchange", signalled)
    before = signal.signal(number, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            write_result(here / "out", "new")
    finally:
        signal.signal(number, before)
    assert finished == [here / "out"] and (here / "out" / "data.bin").read_text() == "new"
    assert sorted(path.name for path in here.iterdir()) == ["cwd", "out"]


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("kills", "stride"), [(20, 5), pytest.param(200, 1, marks=pytest.mark.sweep)], ids=["some", "all"]
)
def test_killed_at_any_moment_the_old_or_the_new_is_there_whole(tmp_path, kills, stride):
    """Just before every (fifth) file operation, and at random instants; and the next run sweeps up."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.results.write.crash", str(tmp_path / "out"), str(kills), str(stride)],
        capture_output=True, text=True, timeout=600, cwd=ROOT, env=os.environ | {"PYTHONPATH": f"{ROOT}/src:{ROOT}"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout)
    assert told["kills"] == kills + -(-told["steps"] // stride) and told["steps"] > 60
    # Both outcomes came up, and so did kills in the midst of the work.
    assert set(told["seen"]) == {0, 1} and told["stale"] > kills // 4
    assert told["left"] == [] and [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_file_of_a_folder_that_the_disk_does_not_take_is_told_by_the_place_of_the_folder(here):
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with (
        pytest.raises(UsageError) as caught,
        whole_folder(here / "out", seal="plan.json") as new,
        whole_file(new / "data.bin"),
    ):
        raise full
    assert str(caught.value) == f"{here / 'out'}: cannot write: no space left on device"
    assert caught.value.__context__ is full and [path.name for path in here.iterdir()] == ["cwd"]
