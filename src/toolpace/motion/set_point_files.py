"""The set-points of a plan on disk: setpoints.npz, which anybody can read, or setpoints.compact, a thirtieth of it.

setpoints.compact holds set-points exactly:

    "toolpace set-points 1" -- a line of JSON: joints, time step, rows, columns of the tool -- blocks of 32768 rows

A block is its length in bytes, a number of four bytes, and the packed whole numbers of its columns
(packed_numbers.py): times by their bits, less those of the time step; positions and derivatives, less what is
predicted; block numbers and lengths of tools, less the one before; tip and axis by their bits, less those of forward
kinematics, so that nothing is left. Blocks are worked on by all cores.

Of positions fifth differences are left. Derivatives are predicted by central differences over time steps dt:

    velocity      (45 (q[+1] - q[-1]) - 9 (q[+2] - q[-2]) + (q[+3] - q[-3])) / (60 dt)
    acceleration  2 (q[+1] - 2 q + q[-1]) / dt^2 - (v[+1] - v[-1]) / (2 dt)
    jerk          (8 (a[+1] - a[-1]) - (a[+2] - a[-2])) / (12 dt)

Each takes what is known already, so all rows are predicted at once, in writing and in reading alike. Every operation
rounds as IEEE 754 says, one after the other, so that both predict the same on any computer.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from threading import Lock
from typing import Any, BinaryIO

import msgspec
import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.files import Spool, whole_file
from toolpace.common.files.atomic import read_binary, refuse_other_format
from toolpace.common.workers import Workers
from toolpace.machine.machine import Machine
from toolpace.motion.packed_numbers import (
    AS_THEY_ARE,
    DamagedError,
    bits_of,
    pack,
    unpack,
    values_of,
    whole_numbers,
)
from toolpace.motion.sampling import each_block
from toolpace.motion.setpoints import ROWS, Block, SetPoints, SetPointSource

ORDER = 5
"""Of the differences of positions: of the orders 3 to 7 this one leaves the fewest bits (docs/design/set_points.md)."""
KINDS = 4
"""Columns of a joint: position and three derivatives."""
REACH = (0, 3, 1, 2)
"""Rows before and behind that a prediction takes."""
_LARGEST = 2.0**62
"""A prediction beyond is none."""
MAGIC = b"toolpace set-points 1\n"
LONGEST_HEAD = 1 << 16
"""Most bytes of the line of JSON."""
FULL_FILE, COMPACT_FILE, MACHINE = "setpoints.npz", "setpoints.compact", "machine.toml"
"""Names of the files."""
FORMS = ("auto", "full", "compact", "no")
"""How set-points are written; auto: in full where that is small."""
OLD_WORDS = {"all": "full", "none": "no", True: "full", False: "no"}
"""What was said before, and is still understood."""
SMALL = 20e6
"""Most bytes of a file that auto writes in full."""
LEAST_BYTES = 0.15
"""Of the compact file for each number of the full one: 0.15 to 0.32 were measured (docs/design/set_points.md)."""


def residuals(jets: Floats, dt: float) -> tuple[list[Ints], list[int]]:
    """What is left (n,) of each of a joint's columns (4, n), and the exponents of their grids, for `jets_of`."""
    left, exponents = [], []
    for kind in range(KINDS):
        numbers, exponent = whole_numbers(jets[kind])
        if kind == 0:
            for _ in range(ORDER):
                numbers = np.diff(numbers, prepend=np.int64(0))
        else:
            numbers = numbers - predicted(jets, kind, dt, exponent)
        left.append(numbers)
        exponents.append(exponent)
    return left, exponents


def jets_of(left: list[Ints], exponents: list[int], dt: float, out: Floats) -> None:
    """Put the columns (4, n) that `residuals` took into `out`. Raises DamagedError for exponents of none."""
    for kind in range(KINDS):
        numbers = left[kind]
        if kind == 0:
            for _ in range(ORDER):
                numbers = np.cumsum(numbers)
        else:
            numbers = numbers + predicted(out, kind, dt, exponents[kind])
        out[kind] = values_of(numbers, exponents[kind])


def predicted(jets: Floats, kind: int, dt: float, exponent: int) -> Ints:
    """(n,) the whole numbers of a derivative that the columns before it in jets (4, n) tell; zeros at the ends."""
    count, reach = jets.shape[1], REACH[kind]
    guess = np.zeros(count, dtype=np.int64)
    if exponent == AS_THEY_ARE or count <= 2 * reach:
        return guess

    def across(values: Floats, steps: int) -> Floats:
        """What values (n,) change by from so many steps before to as many behind."""
        return values[reach + steps : count - reach + steps] - values[reach - steps : count - reach - steps]

    q, v, a, _ = jets
    with np.errstate(all="ignore"):
        if kind == 1:
            found = (45.0 * across(q, 1) - 9.0 * across(q, 2) + across(q, 3)) / (60.0 * dt)
        elif kind == 2:
            found = 2.0 * ((q[2:] - q[1:-1]) - (q[1:-1] - q[:-2])) / (dt * dt) - across(v, 1) / (2.0 * dt)
        else:
            found = (8.0 * across(a, 1) - across(a, 2)) / (12.0 * dt)
        found = np.rint(found * 2.0**-exponent)
        guess[reach : count - reach] = np.where(np.abs(found) < _LARGEST, found, 0.0)
    return guess


class CompactWriter:
    """Packs set-points of a machine block by block, in any order and in any thread, and writes them when all are
    there: exactly, but for the sign of zeros."""

    def __init__(self, source: SetPointSource, machine: Machine) -> None:
        """Take where they are from, and the machine that they will be read for."""
        self.head, self.machine = Head.of(source), machine
        self._packed = Spool()

    def take(self, block: Block) -> None:
        """Pack a block of `ROWS` rows, or the last one."""
        self._packed.put(block.begin, _packed_block(block.points, self.machine, self.head, block.begin))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file, whole or not at all. Raises UsageError."""
        with whole_file(path) as temporary, temporary.open("wb") as stream:
            stream.write(MAGIC + msgspec.json.encode(self.head) + b"\n")
            for begin in range(0, self.head.rows, ROWS):
                data = self._packed.get(begin)
                stream.write(len(data).to_bytes(4, "little") + data)


def write_compact(path: str | os.PathLike[str], points: SetPoints, machine: Machine) -> None:
    """Write set-points of a machine, whole or not at all: exactly, but for the sign of zeros. Raises UsageError."""
    writer = CompactWriter(points, machine)
    each_block(points, (writer.take,))
    writer.write(path)


def read_compact(path: str | os.PathLike[str], machine: Machine) -> SetPoints:
    """Read what `write_compact` wrote for this machine. Raises UsageError, naming the file, where it is missing,
    damaged, cut short or another thing."""
    return read_binary(path, lambda stream: _read(stream, machine), "`toolpace plan` writes it", "a set-points file")


def _read(stream: BinaryIO, machine: Machine) -> SetPoints:
    """The set-points of an open file. Raises DamagedError and others, UsageError for another machine."""
    head = _head(stream, machine)
    blocks = _block_places(stream, head)
    arrays = head.arrays()
    lock = Lock()

    def unpack_block(number: int) -> None:
        start, length = blocks[number]
        with lock:
            stream.seek(start)
            data = stream.read(length)
        _unpack_block(data, head, machine, arrays, number * ROWS)

    Workers().each(unpack_block, range(len(blocks)))
    return SetPoints(**arrays, joints=head.joints)


class Head(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the line of JSON says."""

    joints: tuple[str, ...]
    dt: float
    """Time step [s]."""
    rows: int
    tool: bool
    """Whether tip and axis are there."""
    tool_length: bool
    """Whether lengths of tools are there."""

    @classmethod
    def of(cls, source: SetPointSource) -> Head:
        """That of set-points."""
        first = source.rows(0, min(len(source), 2))
        dt = float(first.t[1] - first.t[0]) if len(first) > 1 else 0.0
        return cls(source.joints, dt, len(source), source.has_tool, len(first.tool_length) > 0)

    @property
    def columns(self) -> int:
        """How many there are in a block."""
        return KINDS * len(self.joints) + 2 + 6 * self.tool + self.tool_length

    def arrays(self) -> dict[str, np.ndarray[Any, Any]]:
        """Room for set-points."""
        n, m, tools = self.rows, len(self.joints), self.rows * self.tool
        shapes = {"t": (n,), "q": (n, m), "qd": (n, m), "qdd": (n, m), "qddd": (n, m), "tip": (tools, 3)}
        shapes |= {"axis": (tools, 3), "tool_length": (n * self.tool_length,)}
        return {name: np.empty(shape) for name, shape in shapes.items()} | {"block": np.empty(n, dtype=np.int64)}


def _head(stream: BinaryIO, machine: Machine) -> Head:
    """The first two lines. Raises DamagedError, and UsageError where the joints are not the machine's."""
    refuse_other_format(stream, MAGIC)
    head = msgspec.json.decode(stream.readline(LONGEST_HEAD), type=Head)
    if not (math.isfinite(head.dt) and head.rows >= 0 and (head.tool or not head.tool_length)):
        raise DamagedError
    if len(head.joints) != len(machine.joints):
        raise UsageError(f"set-points of {len(head.joints)} joints, and {machine.name} has {len(machine.joints)}")
    return head


def _block_places(stream: BinaryIO, head: Head) -> list[tuple[int, int]]:
    """Place and length of every block. Raises DamagedError where they are not all there, or something else is too."""
    size = stream.seek(0, 2) if (begin := stream.tell()) else 0
    if head.rows > size * ROWS:
        raise DamagedError
    places = []
    for _ in range(0, head.rows, ROWS):
        stream.seek(begin)
        length = int.from_bytes(stream.read(4), "little")
        begin += 4 + length
        if begin > size:
            raise DamagedError
        places.append((begin - length, length))
    if begin != size:
        raise DamagedError
    return places


def _packed_block(points: SetPoints, machine: Machine, head: Head, begin: int) -> bytes:
    """A block of set-points whose first is that of row `begin`."""
    left, exponents = [bits_of(points.t) - bits_of(_times(head.dt, slice(begin, begin + len(points))))], []
    for j in range(len(points.joints)):
        jets = np.stack([each[:, j] for each in (points.q, points.qd, points.qdd, points.qddd)])
        of_joint, grids = residuals(jets, head.dt)
        left += of_joint
        exponents += grids
    left.append(np.diff(points.block, prepend=np.int64(0)))
    lengths = points.tool_length if head.tool_length else None
    if lengths is not None:
        left.append(np.diff(bits_of(lengths), prepend=np.int64(0)))
    if head.tool:
        for column, kinematics in zip((points.tip, points.axis), machine.forward(points.q, lengths)):
            left += [bits_of(column[:, k]) - bits_of(kinematics[:, k]) for k in range(3)]
    return pack(left, exponents)


def _unpack_block(data: bytes, head: Head, machine: Machine, arrays: dict[str, Any], start: int) -> None:
    """Fill a block of the arrays. Raises DamagedError."""
    rows = slice(start, min(start + ROWS, head.rows))
    m = len(head.joints)
    left, exponents = unpack(data, rows.stop - start, head.columns, KINDS * m)
    columns = iter(left)
    arrays["t"][rows] = (next(columns) + bits_of(_times(head.dt, rows))).view(np.float64)
    jets = np.empty((KINDS, rows.stop - start))
    for j in range(m):
        jets_of(list(islice(columns, KINDS)), exponents[KINDS * j : KINDS * (j + 1)], head.dt, jets)
        for name, values in zip(("q", "qd", "qdd", "qddd"), jets):
            arrays[name][rows, j] = values
    arrays["block"][rows] = np.cumsum(next(columns))
    lengths = None
    if head.tool_length:
        lengths = arrays["tool_length"][rows] = np.cumsum(next(columns)).view(np.float64)
    if head.tool:
        for name, kinematics in zip(("tip", "axis"), machine.forward(arrays["q"][rows], lengths)):
            for k in range(3):
                arrays[name][rows, k] = (next(columns) + bits_of(kinematics[:, k])).view(np.float64)


def _times(dt: float, rows: slice) -> Floats:
    """(n,) times of rows of set-points that begin at zero [s]."""
    times: Floats = dt * np.arange(rows.start, rows.stop, dtype=np.float64)
    return times


def form_named(name: str, value: str | bool) -> str:
    """One of `FORMS`, by its word or an old one. Raises UsageError, beginning with `name`, for another."""
    form = OLD_WORDS.get(value, value)
    if form not in FORMS:
        raise UsageError(f"{name} {str(value)[:40]}: give {', '.join(FORMS[:-1])} or {FORMS[-1]}")
    return str(form)


def form_of(wanted: str, count: int, joints: int) -> str:
    """ "full", "compact" or "no": what is written of so many set-points where one of `FORMS` is wanted."""
    if wanted != "auto":
        return wanted
    return "full" if full_size(count, joints) <= SMALL else "compact"


def full_size(count: float, joints: int) -> float:
    """Bytes that so many set-points with a tool take in full."""
    return 8.0 * count * (1 + 4 * joints + 6 + 1)


def size_of(form: str, count: float, joints: int) -> float:
    """Bytes that so many set-points take, at least where they are compact."""
    return {"full": 1.0, "compact": LEAST_BYTES / 8.0, "no": 0.0}[form] * full_size(count, joints)


def file_of(form: str) -> str:
    """Name of the file of "full" or "compact"; empty of "no"."""
    return {"full": FULL_FILE, "compact": COMPACT_FILE, "no": ""}[form]


def set_points_file(folder: Path) -> str:
    """Name of the file with set-points in the folder of a plan; empty where there is none. UsageError where both are
    there: which of them would be meant?"""
    there: Sequence[str] = [name for name in (FULL_FILE, COMPACT_FILE) if os.path.lexists(folder / name)]
    if len(there) > 1:
        raise UsageError(f"{folder}: holds {FULL_FILE} and {COMPACT_FILE}; plan again, into a new folder")
    return there[0] if there else ""


def read_set_points(folder: str | os.PathLike[str], machine: Machine | None = None) -> SetPoints:
    """The set-points in the folder of a plan, whichever of both files holds them.

    `machine` is that of the folder's machine.toml, which is read where none is given. Raises UsageError where a file is
    missing, damaged, or another thing.
    """
    place = Path(folder)
    if set_points_file(place) != COMPACT_FILE:
        return SetPoints.load(place / FULL_FILE)
    return read_compact(place / COMPACT_FILE, machine or Machine.load(place / MACHINE))
