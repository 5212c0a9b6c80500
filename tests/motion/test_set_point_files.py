"""Compact set-points are those that were written, to the bit; a damaged file is refused in one line."""

from __future__ import annotations

from dataclasses import fields, replace

import msgspec
import numpy as np
import pytest

from tests.support import motions
from toolpace.common.errors import UsageError
from toolpace.motion.sampling import COARSEST, SHARE, grids, round_to
from toolpace.motion.set_point_files import MAGIC, ROWS, Head, read_compact, write_compact
from toolpace.motion.setpoints import SetPoints

MACHINE = motions.machine()
POINTS = motions.set_points(dt=1e-3)
KINDS = ("q", "qd", "qdd", "qddd")


def on_grid(points):
    """Set-points rounded as those of a plan on disk are."""
    columns = [getattr(points, name).copy() for name in KINDS]
    for grid, values in zip(grids(MACHINE.limits, points.t[1]), columns):
        round_to(grid, values)
    tip, axis = MACHINE.forward(columns[0])
    return replace(points, **dict(zip(KINDS, columns)), tip=tip, axis=axis)


def first(points, count):
    """The first rows of set-points, over and over."""
    rows = np.arange(count) % len(points)
    names = ("q", "qd", "qdd", "qddd", "tip", "axis", "block")
    return replace(points, t=1e-3 * np.arange(count), **{name: getattr(points, name)[rows] for name in names})


def of_noise(count, scale):
    r = np.random.default_rng(7)
    columns = {name: scale * r.standard_normal((count, 5)) for name in KINDS}
    tip, axis = r.standard_normal((2, count, 3))
    return SetPoints(
        t=np.sort(r.random(count)), **columns, tip=tip, axis=axis, block=r.integers(-(2**62), 2**62, count),
        joints=MACHINE.joints, tool_length=r.random(count),
    )  # fmt: skip


def without_a_tool(points):
    none = np.empty((0, 3))
    wild = points.qddd.copy()
    wild[3:6, 0] = np.nan, np.inf, -np.inf
    return replace(points, tip=none, axis=none, qddd=wild)


CASES = {
    "of a plan": on_grid(POINTS),
    "not rounded": POINTS,
    "of noise": of_noise(1000, 1.0),
    "of tiny noise": of_noise(1000, 1e-290),
    "of huge noise": of_noise(1000, 1e150),
    "without a tool, not finite": without_a_tool(POINTS),
    "with tools of other lengths": replace(POINTS, tool_length=np.where(POINTS.t < 1.0, 0.15, 0.12)),
    "of microseconds": replace(POINTS, t=1e-6 * np.arange(len(POINTS))),
    "all at one time": replace(POINTS, t=np.zeros(len(POINTS))),
}
CASES |= {f"{count} rows": first(on_grid(POINTS), count) for count in (0, 1, 2, 3, 6, 7, ROWS - 1, ROWS, ROWS + 1)}


@pytest.mark.parametrize("case", CASES)
def test_what_is_read_is_what_was_written_to_the_bit(case, tmp_path):
    points = CASES[case]
    write_compact(tmp_path / "points", points, MACHINE)
    again = read_compact(tmp_path / "points", MACHINE)
    for each in fields(SetPoints):
        np.testing.assert_array_equal(getattr(again, each.name), getattr(points, each.name), strict=True)


def test_two_blocks_of_a_plan_take_a_twentieth_of_the_full_file(tmp_path):
    points = first(on_grid(POINTS), 2 * ROWS)
    points.save(tmp_path / "full")
    write_compact(tmp_path / "compact", points, MACHINE)
    assert (tmp_path / "compact").stat().st_size < (tmp_path / "full").stat().st_size / 20


@pytest.mark.parametrize("dt", [1e-5, 1e-3, 4e-3, 0.1, 10.0])
def test_rounding_shows_as_a_share_of_every_limit_and_not_in_positions(dt):
    """The worst case of a third difference, 8 times half the grid, is held against the jerk limit."""
    grid, limits = grids(MACHINE.limits, dt), MACHINE.limits
    assert (np.log2(grid) % 1.0 == 0.0).all()
    assert (grid[0] <= COARSEST).all()
    assert (4.0 * grid[0] / dt**3 <= SHARE * limits.jerk).all()
    for of_kind, limit in zip(grid[1:], (limits.velocity, limits.acceleration, limits.jerk)):
        assert (of_kind <= 16.0 * SHARE * limit).all()


def test_what_is_rounded_is_a_multiple_of_its_grid_and_nearest_to_what_it_was():
    values = np.random.default_rng(3).standard_normal((1000, 2)) * [1.0, 1e-12]
    values[0] = -1e-20, 0.0
    grid, was = np.array([2.0**-40, 2.0**-44]), values.copy()
    round_to(grid, values)
    assert (np.abs(values - was) <= 0.5 * grid).all() and (values / grid % 1.0 == 0.0).all()
    assert not np.signbit(values[0]).any()


def test_a_machine_without_limits_has_a_grid_too():
    none = np.full(5, np.inf)
    free = replace(MACHINE.limits, velocity=none, acceleration=none, jerk=none)
    assert (grids(free, 1e-3)[0] == COARSEST).all()


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    path = tmp_path_factory.mktemp("compact") / "points"
    write_compact(path, first(on_grid(POINTS), ROWS + 10), MACHINE)
    return path.read_bytes()


def refused(path, data, words="damaged or not a set-points file"):
    path.write_bytes(data)
    with pytest.raises(UsageError, match=words) as caught:
        read_compact(path, MACHINE)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("seed", range(30))
def test_a_changed_byte_in_a_block_is_found(data, tmp_path, seed):
    r = np.random.default_rng(seed)
    begin = data.index(b"\n", len(MAGIC)) + 1
    at = int(r.integers(begin, len(data)))
    refused(tmp_path / "points", data[:at] + bytes([data[at] ^ int(r.integers(1, 256))]) + data[at + 1 :])


@pytest.mark.parametrize("share", [0.0, 1e-4, 0.01, 0.5, 0.99])
def test_a_file_that_was_cut_short_or_goes_on_is_refused(data, tmp_path, share):
    refused(tmp_path / "points", data[: int(share * len(data))])
    refused(tmp_path / "points", data + data[: 1 + int(share * len(data))])


@pytest.mark.parametrize(
    "change",
    [{"rows": 1}, {"rows": 10**15}, {"rows": -1}, {"rows": 2 * ROWS + 11}, {"tool": False}, {"dt": 1e400}, {"more": 1},
     {"tool_length": True}, {"joints": 3}],
    ids=str,
)  # fmt: skip
def test_a_head_that_says_another_thing_is_refused(data, tmp_path, change):
    """Before memory is taken for what it tells of."""
    end = data.index(b"\n", len(MAGIC))
    head = msgspec.json.decode(data[len(MAGIC) : end]) | change
    refused(tmp_path / "points", MAGIC + msgspec.json.encode(head) + data[end:])


def test_set_points_of_another_machine_are_refused(data, tmp_path):
    end = data.index(b"\n", len(MAGIC))
    head = msgspec.structs.replace(msgspec.json.decode(data[len(MAGIC) : end], type=Head), joints=("X", "Y"))
    refused(tmp_path / "points", MAGIC + msgspec.json.encode(head) + data[end:], "set-points of 2 joints")


def test_what_is_no_file_is_told(tmp_path):
    with pytest.raises(UsageError, match=r"points: no such file; `toolpace plan` writes it"):
        read_compact(tmp_path / "points", MACHINE)
    with pytest.raises(UsageError, match="cannot read: is a directory"):
        read_compact(tmp_path, MACHINE)
    with pytest.raises(UsageError, match="cannot write"):
        (tmp_path / "file").write_text("")
        write_compact(tmp_path / "file" / "points", POINTS, MACHINE)
    assert [each.name for each in tmp_path.iterdir()] == ["file"]


def test_a_file_in_the_format_of_another_version_is_told(data, tmp_path):
    words = "points: is in a format of another version of toolpace, which this one does not read; plan again"
    refused(tmp_path / "points", b"toolpace set-points 9\n" + data[len(MAGIC) :], words)
