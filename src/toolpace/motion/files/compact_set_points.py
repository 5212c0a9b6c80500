"""setpoints.compact: set-points exactly, in about a thirtieth of the room.

    "toolpace set-points 1" -- a line of JSON: joints, time step, rows, columns of the tool -- blocks of 32768 rows

A block is its length in bytes, a number of four bytes, and the packed whole numbers of its columns
(packed_integers.py): times by their bits, less those of the time step; positions and derivatives, less what is
predicted (set_point_prediction.py); block numbers and lengths of tools, less the one before; tip and axis by their
bits, less those of forward kinematics, so that nothing is left. Blocks are worked on by all cores.
"""

from __future__ import annotations

import math
import os
from itertools import islice
from threading import Lock
from typing import TYPE_CHECKING, Any, BinaryIO

import msgspec
import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import whole_file
from toolpace.common.files.atomic import read_binary
from toolpace.common.workers import Workers
from toolpace.motion.files.packed_integers import DamagedError, bits_of, pack, unpack
from toolpace.motion.files.set_point_prediction import KINDS, jets_of, residuals
from toolpace.motion.sampling import each_block
from toolpace.motion.setpoints import ROWS, Block, SetPoints, SetPointSource

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

MAGIC = b"toolpace set-points 1\n"
LONGEST_HEAD = 1 << 16
"""Most bytes of the line of JSON."""


class CompactWriter:
    """Packs set-points of a machine block by block, in any order and in any thread, and writes them when all are
    there: exactly, but for the sign of zeros."""

    def __init__(self, source: SetPointSource, machine: Machine) -> None:
        """Take where they are from, and the machine that they will be read for."""
        self.head, self.machine = Head.of(source), machine
        self._packed: dict[int, bytes] = {}

    def take(self, block: Block) -> None:
        """Pack a block of `ROWS` rows, or the last one."""
        self._packed[block.begin] = _packed_block(block.points, self.machine, self.head, block.begin)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file, whole or not at all. Raises UsageError."""
        with whole_file(path) as temporary, temporary.open("wb") as stream:
            stream.write(MAGIC + msgspec.json.encode(self.head) + b"\n")
            for begin in range(0, self.head.rows, ROWS):
                data = self._packed[begin]
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
    if stream.read(len(MAGIC)) != MAGIC:
        raise DamagedError
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
