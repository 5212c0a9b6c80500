"""Set-points survive the disk, and a file that is something else is refused in one line."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from tests.support import motions
from tests.support.growth import python_calls
from toolpace.common.errors import UsageError
from toolpace.motion.setpoints import SetPoints

POINTS = motions.set_points(dt=1e-2)


def test_round_trip(tmp_path):
    path = tmp_path / "setpoints.npz"
    POINTS.save(path)
    again = SetPoints.load(path)
    for f in fields(SetPoints):
        np.testing.assert_array_equal(getattr(again, f.name), getattr(POINTS, f.name))
    assert again.joints == POINTS.joints
    assert sorted(np.load(path).files) == sorted({f.name for f in fields(SetPoints)} - {"tool_length"})
    assert [p.name for p in tmp_path.iterdir()] == ["setpoints.npz"]


def test_arrays_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        POINTS.q[0, 0] = 1.0


def test_shapes_are_checked():
    with pytest.raises(UsageError, match=r"qd has shape \(2, 5\)"):
        SetPoints(
            *(np.zeros(s) for s in ((3,), (3, 5), (2, 5), (3, 5), (3, 5), (3, 3), (3, 3))),
            block=np.zeros(3, dtype=np.int64),
            joints=tuple("XYZAC"),
        )


def test_lists_are_taken_for_arrays():
    """A block number among them: whole numbers of 8 bytes that nobody writes to, as all that is read takes them."""
    q = [[0.0], [1.0], [2.0]]
    points = SetPoints([0.0, 1.0, 2.0], q, q, q, q, np.zeros((0, 3)), np.zeros((0, 3)), [7.0, 8.0, 8.0], ("X",))
    assert points.q.dtype == np.float64 and points.block.dtype == np.int64
    assert points.block.tolist() == [7, 8, 8] and not points.block.flags.writeable


def test_one_set_point_has_a_tool_where_its_tip_is_told():
    assert still(1).has_tool and "with the tool" in repr(still(1))
    none = np.zeros((0, 3))
    one = np.zeros((1, 5))
    bare = SetPoints(np.zeros(1), one, one, one, one, none, none, np.zeros(1, dtype=np.int64), tuple("XYZAC"))
    assert not bare.has_tool and "without a tool" in repr(bare)


def damaged(path, kind):
    """A file that is no set-points file."""
    if kind == "missing":
        return path
    if kind == "folder":
        path.mkdir()
    elif kind == "empty":
        path.write_bytes(b"")
    elif kind == "text":
        path.write_text("G1 X1\n")
    elif kind == "foreign":
        np.savez(path, a=np.zeros(3))
    elif kind == "one array":
        with path.open("wb") as stream:
            np.save(stream, np.zeros(3))
    elif kind == "strings":
        arrays = {f.name: getattr(POINTS, f.name) for f in fields(SetPoints)} | {"q": np.array(["a"])}
        np.savez(path, **arrays)
    elif kind == "pickle":
        np.savez(path, **{f.name: np.array([{}], dtype=object) for f in fields(SetPoints)})
    else:
        POINTS.save(path)
        path.write_bytes(path.read_bytes()[:-1000] if kind == "truncated" else path.read_bytes()[:5000])
    return path


KINDS = ["missing", "folder", "empty", "text", "foreign", "one array", "strings", "pickle", "truncated", "stump"]


@pytest.mark.parametrize("kind", KINDS)
def test_refuses_another_file_in_one_line(tmp_path, kind):
    path = damaged(tmp_path / "setpoints.npz", kind)
    with pytest.raises(UsageError) as caught:
        SetPoints.load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_written_is_an_error_and_leaves_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot write"):
        POINTS.save(tmp_path / "file" / "setpoints.npz")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def still(n):
    """Set-points of a machine that stands."""
    shapes = ((n,), (n, 5), (n, 5), (n, 5), (n, 5), (n, 3), (n, 3))
    return SetPoints(*(np.zeros(s) for s in shapes), block=np.zeros(n, dtype=np.int64), joints=tuple("XYZAC"))


def test_set_points_are_written_and_read_by_the_megabyte_not_one_by_one(tmp_path):
    def there_and_back(points):
        points.save(tmp_path / "points.npz")
        SetPoints.load(tmp_path / "points.npz")

    few, many = still(1_000), still(200_000)
    there_and_back(few)
    more = python_calls(lambda: there_and_back(many)) - python_calls(lambda: there_and_back(few))
    # 46 MB
    assert more < 20_000
