"""Every block of the smooth path has the feed and the least time of its own block of the program, where that lies."""

from __future__ import annotations

import numpy as np
import pytest

from toolpace.path.path import Path
from toolpace.programs.reading import read_text

TIP = 1e-5


@pytest.fixture(scope="module")
def fitted():
    """A winding program whose every block has another feed, some of them inverse times; a stop, and a point twice."""
    chance = np.random.default_rng(20261122)
    lines, x = ["G21 G90 G94", "G0 X0 Y0 Z0"], 0.0
    for k in range(60):
        x += float(chance.uniform(0.5, 3.0))
        point = f"G1 X{x:.4f} Y{4.0 * np.sin(0.3 * x):.4f} Z{0.5 * np.cos(0.2 * x):.4f}"
        lines += [f"G93 {point} F{30 + k}", "G94"] if k % 7 == 3 else [f"{point} F{200 + 13 * k}"]
        if k == 30:
            lines.append(f"G9 G1 X{x:.4f}")
    toolpath = read_text("\n".join([*lines, "M30", ""]), None, "gcode")
    return toolpath, Path.fit(toolpath, TIP, 1e-3)


def test_each_block_has_its_own_feed_and_least_time(fitted):
    toolpath, path = fitted
    of = {int(block): k for k, block in enumerate(toolpath.block)}
    assert len(of) == len(toolpath) == 61 and len(path.runs) == 2
    seen = []
    for run in path.runs:
        for k, block in enumerate(run.block.tolist()):
            entry = of[block]
            assert run.feed[k] == toolpath.feed[entry] and run.least_time[k] == toolpath.least_time[entry], block
            seen.append(block)
    assert seen == toolpath.block[1:].tolist()


def test_each_block_begins_where_the_program_has_the_end_of_the_one_before(fitted):
    toolpath, path = fitted
    of = {int(block): k for k, block in enumerate(toolpath.block)}
    for run in path.runs:
        tip = run.evaluate(run.block_start).tip[0]
        entries = np.array([of[int(block)] for block in run.block])
        off = np.linalg.norm(tip - toolpath.tip[np.append(entries - 1, entries[-1])], axis=1)
        # Along the path a block may begin a little sooner or later, as far as corners are cut.
        assert off.max() < 5.0 * TIP
