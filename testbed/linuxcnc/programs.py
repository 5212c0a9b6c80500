"""Random programs of the words that LinuxCNC knows, with tables of offsets, references and tools.

Most can be run; about one in eight has a block that no controller takes. Lines carry their number as N, so that what
an interpreter says of them can be told apart.
"""

from __future__ import annotations

from testbed.linuxcnc import flow, modes, motions
from testbed.linuxcnc.edges import EDGES
from testbed.linuxcnc.job import OFFSETS, Job
from testbed.linuxcnc.writer import Writer

WRONG = (
    "G1 X1 X2", "G2 X900 R1", "G4", "G4 P-1", "G0 G1 X1", "G81 X1 Y1", "G1 X", "X1 G90 G91", "G54 G55", "H2",
    "G10 L2 P12 X1", "G10 L2 P1.3 X1", "M6 T1 T2", "#1=[1/0]", "G1 X[SQRT[-1]]", "G1 X#<never_set>", "G17 G18",
    "G2 X1 Y1", "G1 F-5 X2", "G28.7", "M3 M4", "o900 call", "G80 X1", "G83 X1 Y1 Z-2 R1 Q-1", "G82 X1 Y1 Z-2 R1 L-1",
    "G1 X1 Y", "X1 = 3", "G1 X[1+]", "G1 X[2", "G1 X1)", "G92", "G5 X1", "Q3", "G3 I0 J0", "T-1", "S-5", "G1 K3 X9",
    "G53 X1 G2 I1", "G91 G53 X1 I3", "M61", "G64 P-1", "G1 X1 L2", "G2 X3 Y4 R10 I2", "G10 L20 P1",
    "G52", "G43.1", "D3", "G1 X1 P3", "G0 X1 R2", "G93 G1 X77", "G20 G21",
)  # fmt: skip
"""Blocks that are, most of them, refused."""


def wrong(writer: Writer) -> None:
    """A block that is refused, most likely."""
    writer.put(writer.random.choice(WRONG))


def program(writer: Writer) -> str:
    """The text of a program."""
    common = [motions.line] * 8 + [motions.arc] * 5 + [motions.cycle] * 3
    rare = [
        modes.unit, modes.distance, modes.planes, modes.feed, modes.dwell, modes.offset, modes.position, modes.origin,
        modes.length, modes.tool, motions.machine, motions.reference, modes.mode_of_path, modes.assign, modes.system,
        motions.deleted, flow.loop, flow.call, motions.turn, flow.deep, flow.by_number, modes.at_once, flow.together,
        flow.modes_kept,
    ]  # fmt: skip
    edges = [flow.with_blanks, flow.reckoned, flow.labels, *EDGES]
    # few kinds in each program: a difference is told by what it stands among
    kinds = common + [writer.random.choice(rare) for _ in range(10)]
    if writer.chance(0.6):  # each is refused about every other time
        kinds += [writer.random.choice(edges)] * 2
    writer.put("G21 G90 G94 G17 G91.1 F600 M3 S1000")
    for _ in range(writer.random.randint(3, 14)):
        writer.random.choice(kinds)(writer)
    if writer.chance(0.12):
        wrong(writer)
        motions.line(writer)
    writer.put(writer.random.choice(["M2", "M30"]))
    whole = [line for body in writer.subs for line in body] + writer.lines + writer.behind
    return "".join(_numbered(number, line) + "\n" for number, line in enumerate(whole, start=1))


def _numbered(number: int, line: str) -> str:
    """A line with its number as N word, behind a slash; O-words and comments stand alone."""
    if line[:1] in "oO(;":
        return line
    return f"/N{number} {line[1:]}" if line.startswith("/") else f"N{number} {line}"


def random_job(seed: int) -> Job:
    """A program with tables of offsets, references and tools."""
    writer = Writer(seed)
    text = program(writer)
    offsets = {name: writer.place(0.7) for name in OFFSETS if writer.chance(0.5)}
    references = {1: writer.place(1.0), 2: writer.place(1.0)}
    return Job(text, offsets, references, {1: 50.0, 2: 80.5, 3: writer.random.randint(0, 90)})
