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
from toolpace.common.units import DEGREE, MILLIMETRE, MINUTE, format_time
from toolpace.controls.live.rows import HEAD, KINDS, RowForm
from toolpace.controls.live.server import EVENT, KEPT, LOOPBACK
from toolpace.deflection.following import Follower, SetPoint, Status
from toolpace.deflection.following.law import TO_CORRECTION
from toolpace.kernels.follow import layout
from toolpace.kernels.follow.correction_target import chain_of
from toolpace.kernels.follow.pace import place_on_path
from toolpace.kernels.kinematics.chain import forward
from toolpace.machine.machine import Machine
from toolpace.results.report import shell
from toolpace.results.report.charts import NOTHING, SPEED
from toolpace.results.report.machine_view import machine_view
from toolpace.results.report.packed_arrays import PackedArrays
from toolpace.results.report.player_data import page_json
from toolpace.results.report.words import joint_colour

PLACES = 2000
"""Of the path in the plane."""
KEYFRAMES, APART = 20_000, 0.01
"""Of the path in space: at most so many, and so far apart where fewer are enough [s]."""
SAME_PLACE = 1e-6
"""How far the tip of a machine may be from that of a law to be the one that the law is for [m]."""
PATIENCE = 20.0
"""Longest that the server is waited for, when it begins and when it ends [s]."""
SCRIPTS = ("playback", "tracks", "run", "program", "transport")
IN_SPACE = ("playback", "arrays", "motion", "way", "stock", "workpiece", "scene", "player")
"""Scripts of the page, and those that come first where the machine moves in it."""
UNMEASURED = np.full(3, np.nan).tobytes()
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

    def __init__(self, follower: Follower, title: str, machine: Machine | None = None) -> None:
        """Start the server. `machine` is shown as it moves; without it the tip is shown on its path, in a plane.

        Raises UsageError where the server does not start, where the follower is for another machine, and on Windows.
        """
        if sys.platform == "win32":
            raise UsageError("--watch: Windows has no pipe that takes rows at once or not at all; use Linux or macOS")
        self.dropped = 0
        used = int(follower.piece[layout.USED])
        place = follower.piece[layout.PLACE : layout.COMPLIANCE].view(np.int64)
        scale = np.where(np.isin(np.arange(used), place[:2]), 1.0 / DEGREE, 1.0 / MILLIMETRE)
        token, page = secrets.token_urlsafe(24), live_page(follower, title, scale, machine).encode()
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
        parts.append(UNMEASURED if deflection is None else deflection.tobytes())
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


def live_page(follower: Follower, title: str, scale: Floats, machine: Machine | None = None) -> str:
    """The whole HTML text; `scale` (m,) makes mm and deg of the joints. Raises UsageError for another machine."""
    units = ["°" if each == 1.0 / DEGREE else "mm" for each in scale]
    names = [f"joint {j}" for j in range(len(units))] if machine is None else list(machine.joints)
    data = {
        "duration": follower.duration,
        "event": EVENT,
        "kept": KEPT,
        "kinds": KINDS,
        "units": units,
        "joints": names,
        "way": path_in_plane(follower),
        "status": {int(status): words for status, words in STATUS_WORDS.items()},
    }
    joints = "".join(
        f'<tr><th>{escape(names[j])}</th><td class="n" id="q-{j}"></td><td class="n" id="correction-{j}"></td>'
        f"<td>{unit}</td></tr>"
        for j, unit in enumerate(units)
    )
    fields = {"duration": escape(format_time(follower.duration)), "joints": joints}
    arrays = PackedArrays()
    if machine is not None:
        data["motion"] = motion_in_space(follower, machine, arrays)
    scripts = SCRIPTS if machine is None else (*IN_SPACE, *SCRIPTS[1:])
    return shell.whole_page(__package__, "page", title, fields, page_json(data, arrays), scripts, live=True)


def path_in_plane(follower: Follower) -> list[list[float]]:
    """(2, n) places of the path at even times of it, in the plane in which it is widest [mm]."""
    q, _ = joints_on_path(follower, np.linspace(0.0, follower.duration, PLACES))
    tips, axes = np.empty((PLACES, 3)), np.empty((PLACES, 3))
    forward(chain_of(follower.piece), q, tips, axes)
    middle = tips - tips.mean(axis=0)
    across = np.linalg.svd(middle, full_matrices=False)[2][:2]
    return [[float(f"{value:.6g}") for value in middle @ direction / MILLIMETRE] for direction in across]


def joints_on_path(follower: Follower, times: Floats) -> tuple[Floats, Floats]:
    """(n, 5) positions and velocities of the joints at times of the path [m, rad, s]."""
    found, at = np.empty((2, len(times), layout.JOINTS)), np.empty(4)
    for k, t in enumerate(times):
        for j in range(layout.JOINTS):
            place_on_path(follower.piece, t, j, at)
            found[:, k, j] = at[:2]
    return found[0], found[1]


def motion_in_space(follower: Follower, machine: Machine, arrays: PackedArrays) -> dict[str, object]:
    """What player/player.js takes of the planned motion, without a program. Raises UsageError for another machine."""
    count = int(np.clip(follower.duration / APART, 2, KEYFRAMES))
    times = np.linspace(0.0, follower.duration, count)
    q, qd = joints_on_path(follower, times)
    tips, axes = np.empty((count, 3)), np.empty((count, 3))
    forward(chain_of(follower.piece), q, tips, axes)
    used = len(machine.joints)
    far = np.abs(machine.forward(q[:, :used], np.full(count, machine.tool_length))[0] - tips).max()
    if not far <= SAME_PLACE:
        raise UsageError(f"--machine {machine.name}: the law is for another machine; give the one that it was made for")
    speed = np.linalg.norm(np.gradient(tips, times, axis=0), axis=1) * MINUTE / MILLIMETRE
    table = follower.piece[-int(follower.piece[layout.TOOLS]) * layout.TOOL_COLUMNS :].reshape(-1, layout.TOOL_COLUMNS)
    # a path without a program: all of it is one stretch at feed, of no line and no operation
    none = arrays.add([0])
    return {
        "duration": follower.duration,
        "joints": [{"name": name, "colour": joint_colour(j)} for j, name in enumerate(machine.joints)],
        "channels": [
            {"name": SPEED, "panel": "feed", "joint": -1, "peak": 1.0, "unit": "mm/min", "data": arrays.add(speed, 0.1)}
        ],
        "limits": [], "colours": [], "strip": arrays.add([NOTHING]),
        "passages": {"t": none, "line": none, "operation": none, "kind": none},
        "operations": [], "program": None,
        "keyframes": {
            "t": arrays.add(times, 1e-5),
            "q": [arrays.add(each, 1e-7) for each in q.T[:used]],
            "v": [arrays.add(each, 1e-6) for each in qd.T[:used]],
        },
        "rotary": machine.is_rotary.tolist(),
        "tools": {
            "t": table[:, layout.FROM].tolist(),
            "length": ((machine.tool_length + table[:, layout.LONGER]) / MILLIMETRE).tolist(),
        },
        "machine": machine_view(machine),
    }  # fmt: skip
