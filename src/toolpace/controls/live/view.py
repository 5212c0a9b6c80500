"""The page of a running follower, from the side of the follower: what it sends never makes it wait."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import subprocess
import sys
from html import escape
from types import TracebackType

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.units import DEGREE, MILLIMETRE, format_time
from toolpace.controls.live.rows import HEAD, KINDS, RowForm
from toolpace.controls.live.server import EVENT, KEPT, LOOPBACK
from toolpace.deflection.following import Follower, SetPoint, Status
from toolpace.deflection.following.law import TO_CORRECTION
from toolpace.kernels.follow import layout
from toolpace.kernels.follow.correction_target import chain_of
from toolpace.kernels.follow.pace import place_on_path
from toolpace.kernels.kinematics.chain import forward
from toolpace.results.report import shell

PLACES = 2000
"""Of the path in the plane."""
PATIENCE = 20.0
"""Longest that the server is waited for, when it begins and when it ends [s]."""
SCRIPTS = ("playback", "tracks", "run", "program", "transport")
NOTHING = np.full(3, np.nan).tobytes()
STATUS_WORDS = {
    Status.ENDED: "ended", Status.HELD: "held", Status.STALE: "nothing measured of late",
    Status.FADING: "correction is taken back", Status.AT_LIMIT: "correction at its limit", Status.STOPPING: "stopping",
    Status.NOT_A_NUMBER: "measured: not a number", Status.LATE: "measured too late", Status.ABSURD: "measured: absurd",
    Status.JUMPED: "joints were displaced", Status.SLOWED: "slowed for the correction",
    Status.OVERRIDE_CUT: "override is cut",
}  # fmt: skip


class LiveView:
    """A page that shows what a follower does, at `address`, until it is closed.

    The server is a process of its own. What the follower sends goes into a pipe that takes a row at once or not at all:
    where the server or a browser is slow, or gone, rows are dropped (`dropped` counts them), and the follower goes on.
    """

    address: str
    dropped: int
    _process: subprocess.Popen[bytes]
    _pipe: int | None

    def __init__(self, follower: Follower, title: str) -> None:
        """Start the server. Raises UsageError where it does not start, and on Windows."""
        if sys.platform == "win32":
            raise UsageError("--watch: Windows has no pipe that takes rows at once or not at all; use Linux or macOS")
        self.dropped = 0
        used = int(follower.piece[layout.USED])
        place = follower.piece[layout.PLACE : layout.COMPLIANCE].view(np.int64)
        scale = np.where(np.isin(np.arange(used), place[:2]), 1.0 / DEGREE, 1.0 / MILLIMETRE)
        token, page = secrets.token_urlsafe(24), live_page(follower, title, scale).encode()
        head = {
            "token": token, "page": len(page), "joints": used, "scale": scale.tolist(),
            "limits": machine_limits(follower.piece)[:, :used].tolist(),
        }  # fmt: skip
        self._size = RowForm(used).size
        command = [sys.executable, "-m", "toolpace.controls.live.server"]
        # signals of the terminal are for the follower: the server ends with it
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            for part in (json.dumps(head).encode() + b"\n", page):
                left = memoryview(part)
                while left:
                    left = left[self._process.stdin.write(left) :]
            port = self._process.stdout.readline()
        except OSError:
            port = b""
        if not port.strip().isdigit():
            self.close()
            raise UsageError("--watch: the server of the page did not start; is the loopback (127.0.0.1) there?")
        self.address = f"http://{LOOPBACK}:{int(port)}/{token}/"
        self._pipe = self._process.stdin.fileno()
        os.set_blocking(self._pipe, False)

    def show(self, point: SetPoint, deflection: Floats | None = None) -> None:
        """Send a set-point, with the deflection (3,) that was measured [m]; dropped where it would have to wait."""
        if self._pipe is None:
            self.dropped += 1
            return
        parts = [HEAD.pack(point.t, point.path_time, point.pace, int(point.status))]
        parts += [each.tobytes() for each in (point.q, point.qd, point.qdd, point.qddd, point.correction)]
        parts.append(NOTHING if deflection is None else deflection.tobytes())
        try:
            os.write(self._pipe, b"".join(parts))
        except BlockingIOError:
            self.dropped += 1
        except OSError:  # the server is gone
            self.dropped += 1
            self._pipe = None

    def close(self) -> None:
        """End the server; browsers are told."""
        self._pipe = None
        process = self._process
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def __enter__(self) -> LiveView:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def machine_limits(piece: Floats) -> Floats:
    """(3, m) of the joints: what a law leaves to path and pace is all but the share of the correction."""
    has_machine = piece[layout.FRAME : layout.GROUP].any()
    share = TO_CORRECTION * piece[layout.FEED_SHARE] if has_machine else 0.0
    found: Floats = piece[layout.ROOM : layout.LOW].reshape(3, -1) / (1.0 - share)
    return found


def live_page(follower: Follower, title: str, scale: Floats) -> str:
    """The whole HTML text; `scale` (m,) makes mm and deg of the joints."""
    units = ["°" if each == 1.0 / DEGREE else "mm" for each in scale]
    data = {
        "duration": follower.duration,
        "event": EVENT,
        "kept": KEPT,
        "kinds": KINDS,
        "units": units,
        "way": path_in_plane(follower),
        "status": {int(status): words for status, words in STATUS_WORDS.items()},
    }
    joints = "".join(
        f'<tr><th>joint {j}</th><td class="n" id="q-{j}"></td><td class="n" id="correction-{j}"></td>'
        f"<td>{unit}</td></tr>"
        for j, unit in enumerate(units)
    )
    fields = {"duration": escape(format_time(follower.duration)), "joints": joints}
    text = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    return shell.whole_page(__package__, "page", title, fields, text, SCRIPTS, live=True)


def path_in_plane(follower: Follower) -> list[list[float]]:
    """(2, n) places of the path at even times of it, in the plane in which it is widest [mm]."""
    piece = follower.piece
    times = np.linspace(0.0, follower.duration, PLACES)
    q, tips, axes, at = np.empty((PLACES, layout.JOINTS)), np.empty((PLACES, 3)), np.empty((PLACES, 3)), np.empty(4)
    for k, t in enumerate(times):
        for j in range(layout.JOINTS):
            place_on_path(piece, t, j, at)
            q[k, j] = at[0]
    forward(chain_of(piece), q, tips, axes)
    middle = tips - tips.mean(axis=0)
    across = np.linalg.svd(middle, full_matrices=False)[2][:2]
    return [[float(f"{value:.6g}") for value in middle @ direction / MILLIMETRE] for direction in across]
