"""trajectory.compact: path and speed laws of a planned program, to the bit.

    "toolpace trajectory 2" -- a line of JSON: of each run its law's kind, and how long its arrays are -- the arrays

Each array holds that of all runs, one after the other, as a packed column (packed_numbers.py) behind its length in
bytes; coefficients of the path's pieces are packed beside them. Runs whose speed the cut limits have their profile of
speed too. Set-points are a sampling of this; what it tells is the plan itself, at any time. How far the fit found the
path off its program is not in it: that is measured, not kept.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, BinaryIO, cast

import msgspec
import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.common.files import whole_file
from toolpace.common.files.atomic import read_binary, refuse_other_format
from toolpace.motion.laws import LinearLaw, QuinticLaw, SplineLaw, TimeLaw
from toolpace.motion.packed_numbers import DamagedError, bits_of, left_of_splines, pack, splines_of, unpack
from toolpace.path.axis_path import AxisPath
from toolpace.path.follow_run import Branch, FollowRun
from toolpace.path.run import SplineRun
from toolpace.programs.speed_profile import SpeedProfile

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

TRAJECTORY = "trajectory.compact"
"""Its name in the folder of a plan."""
MAGIC = b"toolpace trajectory 2\n"
LONGEST_HEAD = 1 << 24
"""Most bytes of the line of JSON: a run takes some hundred."""
MOST_NUMBERS = 1 << 28
"""Most numbers of an array: more is none of ours."""
MOST_PACKED = 32
"""Bytes that a packed number takes at most; a thousand of them are allowed for the head of an array."""
POWERS = 6
"""Coefficients of a piece of the path."""
LAWS: dict[str, tuple[type[TimeLaw], tuple[str, ...]]] = {
    "spline": (SplineLaw, ("nodes", "c", "rest")),
    "linear": (LinearLaw, ("nodes", "z")),
    "quintic": (QuinticLaw, ("s", "speed", "acceleration", "periods")),
}
"""Kinds of laws, and what each is made of."""
OF_PATH = ("breaks", "block_start", "feed", "least_time", "block", "entry")
OF_BRANCH = ("s", "first", "second")
OF_PROFILE = ("place", "speed", "limit")
WHOLE = ("path block", "path entry", "profile limit")
"""Arrays of whole numbers."""


class RunHead(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A run, and how long its arrays are."""

    law: str
    dwell: float
    tool_length: float | None
    path: tuple[int, ...]
    branch: tuple[int, ...]
    """None where the path tells rotary joints."""
    of_law: tuple[int, ...]
    profile: tuple[int, ...] = ()
    """None where the feeds of its blocks alone hold."""


class Head(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The line of JSON."""

    first_dwell: float
    columns: int
    """Of the path: tip and rotary joints (5), or tip and tool axis (6)."""
    runs: tuple[RunHead, ...]
    limits: tuple[str, ...] = ()
    """Names of what sets the speed in the profiles."""


def is_writable(axis_path: AxisPath, laws: Sequence[TimeLaw]) -> bool:
    """Whether path and laws are those of a planned program, of which all can be written."""
    runs = axis_path.runs
    if not all(isinstance(run, FollowRun) and isinstance(run.run, SplineRun) for run in runs):
        return False
    kinds = {kind for kind, _ in LAWS.values()}
    splines = {cast(SplineRun, cast(FollowRun, run).run).coefficients.shape[1:] for run in runs}
    limits = {profile.names for run in runs if (profile := cast(FollowRun, run).profile) is not None}
    return len(splines) == 1 and len(limits) < 2 and all(type(law) in kinds for law in laws)


def write_trajectory(path: str | os.PathLike[str], axis_path: AxisPath, laws: Sequence[TimeLaw]) -> None:
    """Write path and laws that are writable, whole or not at all. Raises UsageError."""
    runs = [cast(FollowRun, run) for run in axis_path.runs]
    splines = [cast(SplineRun, run.run) for run in runs]
    arrays: dict[str, list[Any]] = {}
    heads = []
    for run, spline, law in zip(runs, splines, laws):
        kind = next(name for name, (of_kind, _) in LAWS.items() if type(law) is of_kind)
        path_arrays = {f"path {name}": getattr(spline, name) for name in OF_PATH}
        branch = run.branch
        of_branch = () if branch is None else (branch.s, *np.ascontiguousarray(branch.rotary.T))
        branch_arrays = {f"branch {name}": values for name, values in zip(OF_BRANCH, of_branch)}
        law_arrays = {f"{kind} {name}": np.array(getattr(law, name)) for name in LAWS[kind][1]}
        of_profile = () if run.profile is None else OF_PROFILE
        profile_arrays = {f"profile {name}": getattr(run.profile, name) for name in of_profile}
        parts = path_arrays, branch_arrays, law_arrays, profile_arrays
        for name, values in (item for part in parts for item in part.items()):
            arrays.setdefault(name, []).append(values)
        lengths = [tuple(map(len, part.values())) for part in parts]
        tool_length = None if math.isnan(run.tool_length) else run.tool_length
        heads.append(RunHead(kind, run.dwell, tool_length, *lengths))
    columns = splines[0].coefficients.shape[2]
    limits = next((run.profile.names for run in runs if run.profile is not None), ())
    head = Head(axis_path.first_dwell, columns, tuple(heads), limits)
    with whole_file(path) as temporary, temporary.open("wb") as stream:
        stream.write(MAGIC + msgspec.json.encode(head) + b"\n")
        for name in _lengths(head):
            _put(stream, _differences(np.concatenate(arrays[name])))
        pieces = np.concatenate([spline.coefficients for spline in splines])
        lengths_of_pieces = np.concatenate([np.diff(spline.breaks) for spline in splines])
        for column in left_of_splines(pieces, lengths_of_pieces).reshape(POWERS * columns, -1):
            _put(stream, column)


def read_trajectory(path: str | os.PathLike[str], machine: Machine) -> tuple[AxisPath, tuple[TimeLaw, ...]]:
    """The joint path on a machine and its speed laws. Raises UsageError, naming the file, where it is missing, damaged
    or another thing."""
    missing = "`toolpace plan` writes it for what it plans itself"
    return read_binary(path, lambda stream: _read(stream, machine), missing, "a trajectory")


def _read(stream: BinaryIO, machine: Machine) -> tuple[AxisPath, tuple[TimeLaw, ...]]:
    refuse_other_format(stream, MAGIC)
    head = msgspec.json.decode(stream.readline(LONGEST_HEAD), type=Head)
    if head.columns not in (5, 6) or not head.runs:
        raise DamagedError
    arrays = {}
    for name, lengths in _lengths(head).items():
        numbers = np.cumsum(_get(stream, sum(lengths)))
        values = numbers if name in WHOLE else numbers.view(np.float64)
        arrays[name] = _parts(values, lengths)
    breaks = list(arrays["path breaks"])
    pieces = [len(each) - 1 for each in breaks]
    left = np.stack([_get(stream, sum(pieces)) for _ in range(POWERS * head.columns)])
    if stream.read(1):
        raise DamagedError
    found = splines_of(left.reshape(POWERS, head.columns, -1), np.concatenate([np.diff(each) for each in breaks]))
    arrays |= {"path breaks": iter(breaks), "path coefficients": _parts(found, pieces)}
    return _assembled(head, arrays, machine)


def _assembled(
    head: Head, arrays: dict[str, Iterator[Any]], machine: Machine
) -> tuple[AxisPath, tuple[TimeLaw, ...]]:
    """Path and laws of the arrays, of which each tells that of the next run."""
    tool_lengths = [math.nan if run.tool_length is None else run.tool_length for run in head.runs]
    runs, laws = [], []
    for run, tool_length, own in zip(head.runs, tool_lengths, machine.with_tools(tool_lengths)):
        of_path = {name: next(arrays[f"path {name}"]) for name in (*OF_PATH, "coefficients")}
        _refuse_disorder(of_path)
        profile = None
        if run.profile:
            place, speed, limit = (next(arrays[f"profile {name}"]) for name in OF_PROFILE)
            profile = _profile(place, speed, limit, head.limits)
        spline = SplineRun(**of_path, dwell=run.dwell, tool_length=tool_length, speed_profile=profile)
        branch = None
        if run.branch:
            s, first, second = (next(arrays[f"branch {name}"]) for name in OF_BRANCH)
            _refuse_disorder({"s": s})
            branch = Branch(s, np.column_stack([first, second]))
        runs.append(FollowRun(spline, own, branch))
        kind, names = LAWS[run.law]
        parts = {name: next(arrays[f"{run.law} {name}"]) for name in names}
        _refuse_disorder(parts)
        if kind is SplineLaw:
            parts["rest"] = tuple(parts["rest"].tolist())
        laws.append(kind(**parts))
    return AxisPath(tuple(runs), machine.joints, machine, head.first_dwell), tuple(laws)


def _profile(place: Floats, speed: Floats, limit: Ints, names: tuple[str, ...]) -> SpeedProfile:
    """The profile of speed along a run."""
    try:
        return SpeedProfile(place, speed, limit, names)
    except UsageError as error:
        raise DamagedError(str(error)) from None


def _lengths(head: Head) -> dict[str, list[int]]:
    """Of each array, in the order of the file, how long it is in each run that has it."""
    lengths: dict[str, list[int]] = {}
    for run in head.runs:
        names = [f"path {name}" for name in OF_PATH]
        names += [f"branch {name}" for name in OF_BRANCH] if run.branch else []
        names += [f"{run.law} {name}" for name in LAWS[run.law][1]]
        names += [f"profile {name}" for name in OF_PROFILE] if run.profile else []
        _refuse_other_lengths(run)
        for name, length in zip(names, (*run.path, *run.branch, *run.of_law, *run.profile), strict=True):
            if not 0 <= length <= MOST_NUMBERS:
                raise DamagedError
            lengths.setdefault(name, []).append(length)
    return lengths


def _refuse_other_lengths(run: RunHead) -> None:
    """Raise DamagedError where arrays do not go together: compiled code would read beyond them."""
    pieces, blocks = run.path[0] - 1, run.path[1] - 1
    right = run.path[2:5] == (blocks, blocks, blocks) and run.path[5] in (0, blocks) and min(pieces, blocks) > 0
    right &= not run.branch or (run.branch[0] > 1 and len(set(run.branch)) == 1)
    right &= not run.profile or len(set(run.profile)) == 1
    first = run.of_law[0]
    others = {"spline": (first + 2, 2), "linear": (first,), "quintic": (first, first, first - 1)}[run.law]
    if not right or first < 2 or run.of_law[1:] != others:
        raise DamagedError


def _refuse_disorder(arrays: dict[str, Any]) -> None:
    """Raise DamagedError where parameters do not ascend, or are not finite."""
    for name in ("breaks", "block_start", "s", "nodes"):
        if name in arrays and not (np.diff(arrays[name]) > 0.0).all():
            raise DamagedError
    for name in ("coefficients", "c", "z", "speed", "acceleration"):
        if name in arrays and not np.isfinite(arrays[name]).all():
            raise DamagedError


def _parts(values: Any, lengths: list[int]) -> Iterator[Any]:
    """An array in parts of these lengths."""
    ends = np.cumsum([0, *lengths]).tolist()
    return (np.ascontiguousarray(values[first:last]) for first, last in pairwise(ends))


def _differences(values: Any) -> Ints:
    """Each whole number, or the bits of each, less the one before."""
    numbers = values if values.dtype == np.int64 else bits_of(values)
    return np.diff(numbers, prepend=np.int64(0))


def _put(stream: BinaryIO, column: Ints) -> None:
    data = pack([column], [])
    stream.write(len(data).to_bytes(8, "little") + data)


def _get(stream: BinaryIO, count: int) -> Ints:
    length = int.from_bytes(stream.read(8), "little")
    if length > MOST_PACKED * (count + 1000):
        raise DamagedError(f"{length} bytes for {count} numbers")
    data = stream.read(length)
    return unpack(data, count, 1, 0)[0][0]
