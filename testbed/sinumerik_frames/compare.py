"""A program read by the library, block by block against the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import toolpace as tp
from testbed.sinumerik_frames.maker import Found
from testbed.sinumerik_frames.programs import Program
from toolpace.common.errors import ToolpaceError
from toolpace.programs.reading.setup_file import setup_of_text

DIRECTION = 1e-7
"""Most distance between directions that are one."""


STANDS = 1e-12
"""Most way of a slide that stands [m]."""


@dataclass
class Report:
    """What came of a program."""

    refused: str = ""
    off: float = 0.0
    """Largest distance of the tip from where it must be [m]."""
    axis: float = 0.0
    """The same of the tool axis."""
    beside: float = 0.0
    """Largest distance of points between the ends of blocks from their straight ways [m]."""
    line: int = 0
    """Where the worst is."""


class _Ends(Found):
    """Rotary joints at the end of a block."""

    def __init__(self, chain, path, last, before):
        self.chain, self.path, self.last, self.before = chain, path, last, before
        self.off = 0.0

    def rotary(self, direction):
        if self.last is None:
            found = self.before
        else:
            found = dict(zip(self.path.rotary_joints, self.path.rotary[self.last]))
        q = np.zeros((1, len(self.chain.names)))
        for name, value in found.items():
            q[0, self.chain.names.index(name)] = value
        self.off = float(np.linalg.norm(self.chain.forward(q, 0.0)[1][0] - direction))
        return found


def compare(program: Program) -> Report:
    """Read a program and hold it against the truth."""
    chain, truth = program.chain, program.truth()
    try:
        path = tp.read_text(
            program.text(), tp.Machine.load(program.machine), setup=setup_of_text(program.sheet()),
            controller="sinumerik", name="frames.mpf",
        )  # fmt: skip
    except ToolpaceError as error:
        return Report(refused=str(error))
    report = Report()
    for number, step in enumerate(program.steps, start=1):
        rows = np.flatnonzero(path.block == number)
        last = int(rows[-1]) if len(rows) else None
        start = truth.q.copy()
        known = number > 3  # nothing leads to the first place
        found = _Ends(chain, path, last, truth.rotary())
        step.act(truth, found)
        if step.counts:
            truth.said = truth.words()
        off = axis = beside = 0.0
        if last is None:
            if known:
                off = float(np.linalg.norm(chain.forward(start, truth.length)[0][0] - truth.tip()))
        else:
            off = float(np.linalg.norm(path.tip[last] - truth.tip()))
            axis = max(float(np.linalg.norm(path.axis[last] - truth.axis())), found.off)
        if known and last is not None and truth.arc is not None:
            beside, truth.arc = _off_arc(truth, path, rows), None
        elif known and step.straight and last is not None:
            beside = _beside(truth, path, rows, start)
        if off > report.off or axis > max(report.axis, DIRECTION) or beside > report.beside:
            report.line = number
        report.off, report.axis = max(report.off, off), max(report.axis, axis)
        report.beside = max(report.beside, beside)
    return report


def _off_arc(truth, path, rows):
    """Largest distance of the points of a block from its helix, in the words of the block."""
    centre, radius, begin, rise, angle = truth.arc
    turned = dict(zip(path.rotary_joints, path.rotary[rows].T))
    slides = truth.chain.joints(path.tip[rows], turned, truth.length)[:, truth.slides]
    words = truth.words_of(path.tip[rows], slides)
    away = words[:, :2] - centre
    swept = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
    height = begin + rise * (1.0 + (swept - swept[-1]) / angle)
    return float(max(np.abs(np.hypot(*away.T) - radius).max(), np.abs(words[:, 2] - height).max()))


def _beside(truth, path, rows, start):
    """Largest distance of the points of a block from its straight way: of the tip on the part, or of the slides."""
    chain = truth.chain
    turned_alone = not truth.traori and np.abs(truth.q[truth.slides] - start[truth.slides]).max() < STANDS
    if truth.on_part and not turned_alone:
        first, end, points = chain.forward(start, truth.length)[0][0], truth.tip(), path.tip[rows]
    else:
        turned = dict(zip(path.rotary_joints, path.rotary[rows].T))
        first, end = start[truth.slides], truth.q[truth.slides]
        points = chain.joints(path.tip[rows], turned, truth.length)[:, truth.slides]
    way = end - first
    square = float(way @ way)
    share = np.clip((points - first) @ way / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(points))
    return float(np.linalg.norm(points - first - share[:, None] * way, axis=1).max())
