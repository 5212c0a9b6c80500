"""A component of LinuxCNC's HAL that steps a follower and keeps the streamer's queue full until it is asked to end.

wait for `enable`
lead: rest where the joints stand, on to the start of the path, rest there
turn after turn, about one a period:
    as many rows as the realtime side has taken since; the last is stepped with what is measured now
asked to end: a stop on the path within the limits, and what waits is played
"""

from __future__ import annotations

import gc
import math
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import reason
from toolpace.common.files.atomic import ENDING
from toolpace.common.units import DEGREE, MILLIMETRE, format_time
from toolpace.controls.hal import JOINTS, Request, Rows, approach, make_pins, position, read_request
from toolpace.deflection.following import Follower, Measurement, SetPoint, Status
from toolpace.kernels.follow import layout
from toolpace.kernels.follow.pace import place_on_path
from toolpace.machine.limits import Limits

SLOWEST = 0.1
"""Share of the limits of jerk that standing still from one period to the next may use."""
PATIENCE = 10.0
"""Longest that a stop, or the end of the queue, is waited for [s]."""
STANDING = Request(0.0, None, False)
COLUMNS = (
    "row", "t", *(f"joint_{j}" for j in range(JOINTS)), *(f"correction_{j}" for j in range(JOINTS)),
    "path_time", "pace", "deflection_x", "deflection_y", "deflection_z", "status",
)  # fmt: skip
"""row: number of the row in the queue; s, mm, deg; a deflection where one was counted on, else nan."""
BUFFER = 1 << 20
"""Bytes that are written at once, so that a disk is waited for seldom."""


@dataclass(frozen=True)
class Settings:
    """How a component is set."""

    name: str = "toolpace"
    """Of the component, before each pin."""
    key: int = 0
    """Number of the streamer."""
    backlog: float = 20e-3
    """How far the rows are ahead of the realtime side [s]."""
    record: Path | None = None
    """Where what is given is written."""


class Component:
    """Plays a follower into a streamer."""

    def __init__(
        self,
        follower: Follower,
        hal: Any,
        settings: Settings,
        watch: Callable[[SetPoint, Floats | None], None] = lambda point, deflection: None,
    ) -> None:
        """Make pins and attach to the streamer; `watch` is shown each set-point with the deflection (3,) that it
        counted on [m], and must not wait. Raises UsageError."""
        self.follower, self._watch = follower, watch
        piece = follower.piece
        place = piece[layout.PLACE : layout.COMPLIANCE].view(np.int64)
        self._scale = np.full(JOINTS, 1.0 / MILLIMETRE)
        self._scale[place[:2]] = 1.0 / DEGREE
        self._limits = (piece[layout.SHARE : layout.ROOM] + piece[layout.ROOM : layout.LOW]).reshape(3, JOINTS)
        self._settings = settings
        ahead = math.ceil(settings.backlog / follower.period)
        if ahead < 2:
            raise UsageError(
                f"--backlog {format_time(settings.backlog)}: give two periods ({format_time(2.0 * follower.period)}) or"
                " more"
            )
        if piece[layout.DELAY] < ahead * follower.period * (1.0 - 1e-9):
            raise UsageError(
                f"the law counts on a delay of {format_time(float(piece[layout.DELAY]))}, and a backlog of"
                f" {format_time(ahead * follower.period)} alone is more: make it with delay = backlog + lag of the"
                " drives (and dead_time = that of the sensor), or take a shorter --backlog"
            )
        if not piece[layout.FRAME : layout.GROUP].any():
            raise UsageError("the law is of limits without a machine: make it of a Follower with the machine")
        # each measurement is told the time at which it comes: what the sensor took until then is a part of the delay
        piece[layout.DELAY] += piece[layout.DEAD_TIME]
        piece[layout.DEAD_TIME] = 0.0
        self._ready(hal, ahead)

    def _ready(self, hal: Any, ahead: int) -> None:
        """Load the component, with the kernel compiled before anybody waits for it."""
        self.follower.step(Measurement(0.0, deflection=np.zeros(3)))
        self.follower.reset()
        try:
            self.pins = hal.component(self._settings.name)
        except Exception as error:  # of several kinds in hal
            raise UsageError(
                f"HAL does not take a component '{self._settings.name}' ({error}); is another of this name loaded, or"
                " is LinuxCNC another user's?"
            ) from None
        try:
            make_pins(hal, self.pins)
            self.rows = Rows(hal, self.pins, self._settings.key, ahead)
        except UsageError:
            self.pins.exit()
            raise
        self.pins.ready()

    def run(self) -> None:
        """Play until a signal asks to end. Raises UsageError where the realtime side found no row, or for the record,
        and KeyboardInterrupt at a second signal."""
        try:
            with Record(self._settings.record) as record, without_pauses(), asked_to_end() as ending:
                while not (self.pins["enable"] or ending.asked):
                    time.sleep(self.follower.period)
                if ending.asked:
                    return
                self._lead()
                while not ending.asked:
                    self._turn(record, read_request(self.pins))
                self._stop(record)
        finally:
            self.pins["playing"] = False
            self.pins.exit()

    def _lead(self) -> None:
        """From where the joints stand to the start of the path, at rest before and behind."""
        start, scale = position(self.pins), self._scale
        end, first = start_of(self.follower.piece)
        limits = Limits(self._limits[0], self._limits[1], self._limits[2])
        way = approach(start / scale, end, limits, self.follower.period) * scale
        rest = self.rows.ahead + 2
        for row in (*[start] * rest, *way, *[end * scale] * rest, first * scale):
            while self.rows.room == 0:
                self._look()
                time.sleep(self.follower.period)
            self.rows.write(row.tolist())
            if self.rows.given == self.rows.ahead:
                self._begin()

    def _begin(self) -> None:
        """The queue is full: the realtime side may begin."""
        self.rows.count_from_here()
        self.pins["playing"] = True

    def _turn(self, record: Record, wanted: Request) -> SetPoint | None:
        """Fill the queue; what was measured is of when the last row that it made room for was played."""
        self._look()
        point, room = None, self.rows.room
        if wanted.resume:
            self.follower.resume()
        for k in range(room):
            last = wanted if k == room - 1 else None
            point = self._step(wanted.feed, last)
            row = (point.q * self._scale).tolist()
            record.write(self.rows.given, row, point, point.correction[0] * self._scale, last)
            self.rows.write(row)
            self._watch(point, None if last is None else last.deflection)
        if point is not None:
            self._show(point)
        time.sleep(self.follower.period)
        return point

    def _step(self, feed: float, wanted: Request | None) -> SetPoint:
        if wanted is None or wanted.deflection is None:
            return self.follower.step(feed=feed)
        now = float(self.follower.state[layout.STEPS] + 1.0) * self.follower.period
        return self.follower.step(Measurement(now, deflection=wanted.deflection), feed)

    def _look(self) -> None:
        """Tell how full the queue is, and stop where it was empty."""
        self.pins["backlog"], self.pins["late"] = self.rows.depth, max(self.rows.late, 0)
        if self.pins["playing"] and self.rows.late > 0:
            raise UsageError(
                f"row {self.rows.given} came too late for the servo thread, and the joints stand at once; take a longer"
                f" --backlog than {format_time(self._settings.backlog)} (and a law with as much more delay), or give"
                " this process priority (chrt -f 10)"
            )

    def _show(self, point: SetPoint) -> None:
        pins, ended = self.pins, bool(point.status & Status.ENDED)
        shown: dict[str, float] = {
            "ended": ended, "status": int(point.status), "time": point.t, "path-time": point.path_time,
            "s": point.s, "pace": point.pace,
        }  # fmt: skip
        correction = point.correction[0] * self._scale
        for name, value in shown.items():
            pins[name] = value
        for j in range(JOINTS):
            pins[f"correction-{j}"] = float(correction[j])

    def _stop(self, record: Record) -> None:
        """Stand on the path within the limits, then let what waits be played; a second signal ends at once."""
        until = time.monotonic() + PATIENCE
        stands = not self.pins["playing"]
        # from here on nothing is measured, nor missed: the correction settles where it goes to
        self.follower.state[layout.MEASURED] = 0.0
        while not stands and time.monotonic() < until:
            point = self._turn(record, STANDING)
            stands = point is not None and self._stands(point)
        while self.pins["playing"] and self.rows.depth and time.monotonic() < until:
            time.sleep(self.follower.period)

    def _stands(self, point: SetPoint) -> bool:
        """Whether standing from the next period on takes little of the limits of jerk."""
        period, jerk = self.follower.period, self._limits[2]
        steps: Floats = np.abs(point.qd) / period**2 + np.abs(point.qdd) / period
        return bool((steps <= SLOWEST * jerk).all())


def start_of(piece: Floats) -> tuple[Floats, Floats]:
    """(m,) joints at rest before the path of a piece, and (m,) those at its time 0, where its spline has begun."""
    begin = layout.PATH + layout.COLUMNS
    rest, at = piece[begin : begin + JOINTS].copy(), np.empty(4)
    first = np.empty(JOINTS)
    for j in range(JOINTS):
        place_on_path(piece, 0.0, j, at)
        first[j] = at[0]
    return rest, first


class Ending:
    """Whether a signal has asked to end; a second one ends at once."""

    asked = False

    def hear(self, number: int, frame: FrameType | None) -> None:
        """Note a signal: an exception would tear a set-point that was stepped from the row that it becomes."""
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True


@contextmanager
def asked_to_end() -> Iterator[Ending]:
    """Let signals ask for the end of the block; who ignores one (nohup) goes on doing so."""
    ending = Ending()
    heard = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, ending.hear) for number in heard}
    try:
        yield ending
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def without_pauses() -> Iterator[None]:
    """Nothing is collected meanwhile: among all that compiled kernels hold, that takes longer than the rows last, and
    what a turn makes is freed as it goes out of use."""
    gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


class Record:
    """A file of set-points, or nothing where no file is asked for."""

    def __init__(self, file: Path | None) -> None:
        """Raises UsageError where the file cannot be written."""
        self._stream = None
        if file is not None:
            try:
                self._stream = file.open("w", encoding="utf-8", buffering=BUFFER)
            except OSError as error:
                raise UsageError(f"--record {file}: cannot write: {reason(error)}") from None
            self._stream.write(",".join(COLUMNS) + "\n")

    def __enter__(self) -> Record:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._stream is not None:
            self._stream.close()

    def write(self, row: int, joints: list[float], point: SetPoint, correction: Floats, wanted: Request | None) -> None:
        """One set-point: the row as it was given [mm, deg], and what it was made from."""
        if self._stream is None:
            return
        off = np.full(3, np.nan)
        if wanted is not None and wanted.deflection is not None:
            off = wanted.deflection / MILLIMETRE
        figures = [point.t, *joints, *correction.tolist(), point.path_time, point.pace, *off.tolist()]
        self._stream.write(f"{row},{','.join(map(repr, figures))},{int(point.status)}\n")
