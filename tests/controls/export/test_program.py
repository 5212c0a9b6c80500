"""Target `program`: the same text but for F, the same path, and the times of the plan."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.support.thinned import every
from toolpace import read
from toolpace.common.errors import UsageError, VerificationError
from toolpace.controls.export import export
from toolpace.controls.export.planned_feeds import Job
from toolpace.controls.export.program import Program
from toolpace.controls.export.rewriting import Passes
from toolpace.programs.reading import read_source

F = re.compile(rb"\s*(?<![A-Za-z])(?:F(?:\[[^\]]*\]|[0-9.]+)|G93|G94)")


@pytest.fixture(scope="module")
def refed(plan, tmp_path_factory):
    """The program with the feeds of its plan, and what was said of it."""
    return export(plan, "program", tmp_path_factory.mktemp("program") / "out")


def without_feeds(data):
    return F.sub(b"", data)


def test_the_text_is_kept_to_the_byte_but_for_f(plan, refed):
    before, after = (plan / "program.ngc").read_bytes(), (refed.folder / "program.ngc").read_bytes()
    assert b"\r\n" in before
    changed = [line for line in after.splitlines(keepends=True) if line not in before.splitlines(keepends=True)]
    assert all(b"F" in line for line in changed)
    # One line more: the F that cycle and loop had, again behind the block before them.
    assert [line for line in without_feeds(after).split(b"\n") if line.strip()] == [
        line for line in without_feeds(before).split(b"\n") if line.strip()
    ]
    assert b"N10 X30 F" in after and b" ; along x\r\n" in after
    assert any("with the old feed" in note for note in refed.notes)
    told = next(note for note in refed.notes if "by the model linuxcnc" in note)
    seconds = [float(value) for value in re.findall(r"([0-9.]+) s with", told)]
    assert len(seconds) == 2 and all(15.0 < value < 30.0 for value in seconds)


@pytest.mark.parametrize("inverse", [False, True])
def test_read_again_each_block_takes_the_time_that_the_plan_takes(plan, motion, refed, tmp_path, inverse):
    out = export(plan, "program", tmp_path / "out", inverse_time=True).folder if inverse else refed.folder
    before, after = read(plan / "program.ngc", motion.machine), read(out / "program.ngc", motion.machine)
    assert np.array_equal(before.tip, after.tip) and np.array_equal(before.axis, after.axis)
    assert np.array_equal(before.stop, after.stop) and np.array_equal(before.dwell, after.dwell)
    now = Passes.of(after).asked_times(after)
    passes = Passes.of(before)
    planned = passes.planned_times(before, motion.setpoints)
    chosen = passes.once & ~passes.rapid & ~passes.mixed
    assert chosen.sum() >= 5 and np.allclose(now[chosen], planned[chosen], rtol=1e-5)
    assert planned.sum() + before.dwell.sum() == pytest.approx(motion.duration, abs=1e-3)


def test_times_of_blocks_are_found_between_the_set_points(motion):
    """The same plan with a tenth of its set-points: where it is fast, ends are told to a small part of a time step."""
    toolpath = read_source(motion.source, motion.machine, None, motion.options)
    passes = Passes.of(toolpath)
    fine = passes.ends(toolpath, motion.setpoints)
    coarse = passes.ends(toolpath, every(motion.setpoints, 10))
    off = np.abs(fine - coarse)[:-1]
    assert off.max() <= 10e-3 and np.sort(off)[: len(off) // 2].max() < 2e-3
    assert (np.diff(fine) >= 0.0).all()


def test_straight_blocks_are_cut_into_the_same_way(plan, motion, tmp_path):
    said = export(plan, "program", tmp_path / "out", split=0.1)
    after = read(tmp_path / "out" / "program.ngc", motion.machine)
    before = read(plan / "program.ngc", motion.machine)
    assert len(after) > len(before) + 60
    assert any(re.search(r"blocks divided, \d+ lines added", note) for note in said.notes)
    speed = np.linalg.norm(np.diff(motion.setpoints.tip, axis=0), axis=1) / 1e-3
    cut = np.isfinite(after.feed) & (after.feed > 0)
    assert after.feed[cut].max() <= speed.max() * 1.001
    corners = [np.abs(after.tip - tip).max(axis=1).min() for tip in before.tip[Passes.of(before).last]]
    assert max(corners) < 1e-12


def test_blocks_that_run_often_keep_their_feed(refed):
    lines = (refed.folder / "program.ngc").read_text().splitlines()
    loop = lines.index("o100 repeat [2]")
    assert lines[loop + 1 : loop + 4] == ["  G91 G1 X-4 Y-2", "  X1", "  G90"]
    cycle = lines.index("G81 Z-1 R2 F200")
    # a cycle with an F of its own needs no other in force before it
    assert lines[cycle + 1] == "X5" and lines[cycle - 1].startswith("G1 X0 Y0 A0 C0 F")


def test_a_program_that_reads_differently_is_told(motion, tmp_path):
    target = Program()
    written = target.write(motion, tmp_path)
    file = tmp_path / "program.ngc"
    file.write_bytes(file.read_bytes().replace(b"X30", b"X31"))
    with pytest.raises(VerificationError, match="not what was written"):
        target.check(motion, tmp_path, written)


def test_a_wrong_feed_is_told_with_the_figure(motion, tmp_path):
    """What was written is compared with the plan, not with itself."""
    from dataclasses import replace

    target = Program()
    written = target.write(motion, tmp_path)
    late = replace(written.job, planned=written.job.planned * 1.001)
    with pytest.raises(VerificationError, match=r"largest relative difference of a block's time: 0\.001, allowed"):
        target.check(motion, tmp_path, replace(written, job=late))


def test_set_points_of_another_program_are_refused(motion):
    from dataclasses import replace

    block = motion.setpoints.block.copy()
    block[100:200] = 9999
    with pytest.raises(UsageError, match="name block 9999"):
        Job.of(replace(motion, setpoints=replace(motion.setpoints, block=block)), False, False)
