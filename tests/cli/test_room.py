"""What is said before the work of the room that results will take."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from toolpace.common.errors import UsageError
from toolpace.jobs import job
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import COPIES, STREAMED_COPIES, refuse_too_many
from toolpace.programs.reading import read_text

ROW = 8 * (1 + 4 * 5 + 6 + 1)


def job_of(csv=False, npz="auto", tool=None):
    machine = Machine.load("xyzac-trunnion")
    return SimpleNamespace(machine=machine, dt=1e-3, csv=csv, npz=npz, tool=tool, out=Path("out"))


def test_feeds_least_times_and_dwells_are_what_a_motion_takes_at_least():
    body = "G21 G90 G94\nG0 X0 Y0 Z0\nG1 X10 F600\nG4 P2\nX30 F1200\nG93 X40 F30\nG0 X90\nG94 G1 X100 F600\nM30\n"
    assert read_text(body, None, "gcode").least_duration == pytest.approx(1.0 + 2.0 + 1.0 + 2.0 + 1.0)


@pytest.mark.parametrize(("share", "fine"), [(0.99, True), (1.01, False)])
def test_memory_is_that_of_the_set_points_as_often_as_they_are_held(monkeypatch, share, fine):
    monkeypatch.setattr("toolpace.motion.setpoints.free_memory", lambda: 1000.0 * ROW * COPIES / share)
    if fine:
        refuse_too_many(1.0, 1e-3, 5)
        return
    with pytest.raises(UsageError, match=r"1e\+03 set-points every 0\.001 s.*take a time step of 0\.0011 s or more"):
        refuse_too_many(1.0, 1e-3, 5)


@pytest.mark.parametrize("duration", [0.7, 31.0, 3601.0, 98765.4])
def test_the_time_step_that_is_advised_is_not_refused(monkeypatch, duration):
    monkeypatch.setattr("toolpace.motion.setpoints.free_memory", lambda: 1e5)
    with pytest.raises(UsageError) as refused:
        refuse_too_many(duration, 1e-6, 5)
    refuse_too_many(duration, float(str(refused.value).partition("time step of ")[2].split()[0]), 5)


@pytest.mark.parametrize(
    ("npz", "tool", "copies"),
    [
        ("full", None, COPIES), ("compact", "mill", COPIES), ("compact", None, STREAMED_COPIES),
        ("no", None, STREAMED_COPIES),
    ],
)
@pytest.mark.parametrize(("share", "fine"), [(0.99, True), (1.01, False)])
def test_memory_of_a_plan_is_less_where_its_set_points_are_not_held(monkeypatch, npz, tool, copies, share, fine):
    monkeypatch.setattr("toolpace.motion.setpoints.free_memory", lambda: 1e6 * ROW * copies / share)
    monkeypatch.setattr("toolpace.common.files.free_disk", lambda folder: 1e12)
    if fine:
        job.refuse_without_room(job_of(npz=npz, tool=tool), 1e3, "the motion takes")
        return
    with pytest.raises(UsageError, match=r"set-points: the motion takes 16 min 40\.0 s"):
        job.refuse_without_room(job_of(npz=npz, tool=tool), 1e3, "the motion takes")


def test_memory_is_told_in_gigabytes(monkeypatch):
    """An hour of microseconds, 3.6e9 rows of 28 numbers, three times: 2419 GB."""
    monkeypatch.setattr("toolpace.motion.setpoints.free_memory", lambda: 8e9)
    with pytest.raises(UsageError, match=r"and 2\.42e\+03 GB of memory, of which 8 GB are free"):
        refuse_too_many(3600.0, 1e-6, 5)


@pytest.mark.parametrize(
    ("csv", "npz", "files"), [(False, "full", 1.0), (True, "full", 3.5), (False, "auto", 0.01875), (True, "no", 2.5)]
)
@pytest.mark.parametrize(("share", "fine"), [(0.99, True), (1.01, False)])
def test_disk_is_that_of_the_files(monkeypatch, csv, npz, files, share, fine):
    """With a table two and a half times as much again; five megabytes for the report.

    Compact set-points, as those of 500 s are by themselves, take 0.15 bytes a number at least."""
    task = job_of(csv=csv, npz=npz)
    wanted = 0.5e6 * ROW * files + 5e6
    monkeypatch.setattr("toolpace.common.files.free_disk", lambda folder: wanted / share)
    if fine:
        job.refuse_without_room(task, 500.0, "the motion takes")
        return
    with pytest.raises(UsageError, match=r"--out out: the results take more than"):
        job.refuse_without_room(task, 500.0, "the motion takes")
