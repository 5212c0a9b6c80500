"""One real LinuxCNC at a time, in a folder of its own, as a user without rights, faster than real time.

Needs `apt-get install --no-install-recommends linuxcnc-uspace faketime`. LinuxCNC's `rtapi_app` is installed with the
rights of root, which keeps the library of `faketime` out of it and refuses root himself: root takes that bit away, any
other user runs in real time unless it was.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import pwd
import shutil
import signal
import stat
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

SPEED = 8
"""Times real time; at twenty the interpreter no longer keeps the queue full."""
NOBODY = "nobody"
LOCK = Path("/var/lock/lcnc.lock")
CORE = Path("/usr/bin/rtapi_app")
LAST_WORDS = 1500
"""Most characters of LinuxCNC's output that a message shows."""


class LinuxCNCError(RuntimeError):
    """LinuxCNC is missing, or did not do what it was asked to."""


def missing() -> str:
    """What has to be installed, as one line; empty where nothing has."""
    if not (shutil.which("linuxcnc") and shutil.which("halrun") and CORE.exists()):
        return "LinuxCNC is not installed (apt-get install --no-install-recommends linuxcnc-uspace faketime)"
    return ""


@contextlib.contextmanager
def folder() -> Iterator[Path]:
    """A folder for one run, gone after it."""
    if missing():
        raise LinuxCNCError(missing())
    with tempfile.TemporaryDirectory(prefix="linuxcnc.") as name:
        yield Path(name)


def execute(command: list[str], place: Path, seconds: float, speed: int = SPEED) -> str:
    """Run a command of LinuxCNC's in a folder, alone on this machine; what it printed.

    Raises LinuxCNCError after `seconds` of real time.
    """
    if speed > 1 and shutil.which("faketime") and _no_bit_of_root():
        # by its command, which gives all processes one clock and clears it up: without, each leaves a segment of shared
        # memory named for its number, which keeps a later process of that number from starting
        command = ["faketime", "-f", f"+0 x{speed}", *command]
    command = [*_own_shared_memory(), *_without_rights(place), *command]
    with _alone():
        _clear_clocks()
        output = place / "output.txt"
        with output.open("wb") as printed:
            process = subprocess.Popen(
                command, cwd=place, env=_environment(place), stdin=subprocess.DEVNULL, stdout=printed,
                stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
            try:
                process.wait(seconds)
            except subprocess.TimeoutExpired:
                raise LinuxCNCError(f"LinuxCNC did not end within {seconds:g} s: {_tail(output)}") from None
            finally:
                _end(process)
    return output.read_text(errors="replace")


def _clear_clocks() -> None:
    """Remove the shared memory of clocks whose process is gone: one of the same number could not start."""
    for each in Path("/dev/shm").glob("*faketime_*"):
        number = each.name.rpartition("_")[2]
        if number.isdigit() and not Path("/proc", number).exists():
            with contextlib.suppress(OSError):
                each.unlink()


def _environment(place: Path) -> dict[str, str]:
    return {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": str(place), "USER": "linuxcnc", "LC_ALL": "C.UTF-8"}


def _no_bit_of_root() -> bool:
    """Whether rtapi_app runs with its user's rights; root sees to it."""
    mode = CORE.stat().st_mode
    if mode & stat.S_ISUID and os.geteuid() == 0:
        CORE.chmod(stat.S_IMODE(mode) & ~stat.S_ISUID)
        return True
    return not mode & stat.S_ISUID


def _own_shared_memory() -> list[str]:
    """What starts a command with System V shared memory of its own, where the kernel grants it; empty elsewhere.

    LinuxCNC finds its segments by fixed keys: one that another user has left behind keeps ours from starting.
    """
    root = os.geteuid() == 0
    command = ["unshare", "--ipc"] if root else ["unshare", "--user", "--map-current-user", "--ipc"]
    granted = shutil.which("unshare") and not subprocess.run([*command, "true"], capture_output=True).returncode
    return command if granted else []


def beside(process: int) -> list[str]:
    """What starts a command with the shared memory of a process of LinuxCNC's; empty where that is everybody's."""
    if not _own_shared_memory():
        return []
    user = [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
    return ["nsenter", f"--target={process}", *user, "--ipc"]


def _without_rights(place: Path) -> list[str]:
    """What starts a command as nobody where we are root, and its folder given to him; empty for any other user."""
    if os.geteuid() != 0:
        return []
    who = pwd.getpwnam(NOBODY)
    for path in (place, *place.iterdir()):
        os.chown(path, who.pw_uid, who.pw_gid)
    return ["setpriv", f"--reuid={who.pw_uid}", f"--regid={who.pw_gid}", "--clear-groups"]


@contextlib.contextmanager
def _alone() -> Iterator[None]:
    """LinuxCNC's realtime core is one for the whole machine; so is its shared memory where the kernel divides none."""
    try:
        # another user's file in a folder of all users may be opened, but not with leave to create it
        handle = os.open(LOCK, os.O_RDONLY | (0 if LOCK.exists() else os.O_CREAT), 0o666)
    except OSError as error:
        raise LinuxCNCError(f"{LOCK}: {error.strerror}: nothing keeps a second LinuxCNC away") from None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _end(process: subprocess.Popen[bytes]) -> None:
    """Nothing of a run outlives it: ask its processes to end, which clear up behind themselves, then end them."""
    for how, patience in ((signal.SIGTERM, 20.0), (signal.SIGKILL, 5.0)):
        if not _running(process.pid):
            break
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, how)
        until = time.monotonic() + patience
        while _running(process.pid) and time.monotonic() < until:
            time.sleep(0.05)
    process.wait()


def _running(group: int) -> bool:
    """Whether a process of the group goes on; one that has ended may wait there for somebody to ask how."""
    for each in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, its_group = each.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                return True
    return False


def _tail(output: Path) -> str:
    return " | ".join(output.read_text(errors="replace")[-LAST_WORDS:].split("\n"))


def last_words(text: str) -> str:
    """The end of what LinuxCNC printed, in one line."""
    return " | ".join(line for line in text[-LAST_WORDS:].splitlines() if line.strip())
