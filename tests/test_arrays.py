"""Every public function that takes an array: any kind of array gives the answer of a plain one, or one clear error."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import toolpace as tp
from tests.support.array_cases import AXES, CASES, MACHINE, POSES, TIPS, TURNS, Case
from toolpace.common.errors import ToolpaceError

ARRAYS = ("Floats", "Ints", "Bools", "ArrayLike")
"""What names an array in a signature."""
pytestmark = pytest.mark.filterwarnings("ignore:project. deflection= is called tip= now")

RESULTS = (
    "ActiveLimits", "BendingCompensation", "CutLoads", "EngagementTable", "Geometry", "LeftRegion", "Motion", "PathJet",
    "PlaceMap", "PlannedSetUp", "Probe", "ProgramTime", "SetPoint", "Stations", "ToolProfile",
    "deflection.Projection", "PathRun", "TorqueTerms",
)  # fmt: skip
"""What functions return: nothing public takes one, and nobody need make one."""
SHARES = ("Choices.from_shares", "Choices.shares_of", "Choices.box")
"""Shares of a search, one a name: no array of any shape goes in."""
BETWEEN_ROOMS = (
    "Trajectory.put_motion", "SetPoints.at", "SetPoints.times", "Stations.where", "ToolProfile.surface",
    "Rows.ratio", "Rows.shares", "Rows.steady", "SpeedProfile.at", "SpeedProfile.limit_at", "SpeedProfile.along",
    "AxisRun.cap_names", "CurvedLimit.at", "Dynamics.along", "EngagementTable.at", "LimitCurve.at", "Rows.limits_at",
    "Rows.line_ratios", "Rows.line_shares", "Rows.most_z", "Rows.values",
)  # fmt: skip
"""Planner, sampling, judge and the simulation of a cut call them with arrays that they have made."""
LIVE = ("Measurement", "Measurement.write")
"""A follower takes any figures, and says what it made of them: tests/follow."""


def answer(thing: Any) -> Any:
    """What a call has given, as arrays, numbers and text."""
    if isinstance(thing, tp.Path | tp.AxisPath):
        run = thing.runs[0]
        found = run.evaluate(np.linspace(run.s0, run.s1, 7))
        return answer(list(found)) if isinstance(found, tuple) else found
    if hasattr(thing, "_fields"):
        return [answer(each) for each in thing]
    if dataclasses.is_dataclass(thing) and not isinstance(thing, tp.Machine | tp.Trajectory):
        return [answer(getattr(thing, each.name)) for each in dataclasses.fields(thing)]
    if isinstance(thing, tp.Trajectory):
        return answer(thing.at(np.linspace(0.0, thing.duration, 7)))
    if isinstance(thing, list | tuple):
        return [answer(each) for each in thing]
    return thing


def same(one: Any, other: Any) -> bool:
    if isinstance(one, list):
        return isinstance(other, list) and len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray):
        return np.shape(one) == np.shape(other) and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return bool(one == other) or (one != one and other != other)


def public() -> Iterator[tuple[str, Any]]:
    """Every public function, class and method by its name."""
    roots = {name: getattr(tp, name) for name in tp.__all__ if name not in ("__version__", "deflection", "replan")}
    roots |= {f"deflection.{name}": getattr(tp.deflection, name) for name in tp.deflection.__all__}
    for name, thing in roots.items():
        yield name, thing
        if not inspect.isclass(thing):
            continue
        for method in dir(thing):
            home = next((c for c in thing.__mro__ if method in vars(c)), object)
            if (
                not method.startswith("_")
                and home.__module__.startswith("toolpace")
                and callable(getattr(thing, method))
            ):
                yield f"{name}.{method}", getattr(thing, method)


def arrays_of(thing: Any) -> list[str]:
    """Names of the arguments of a function or class that are arrays."""
    try:
        parameters = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return []
    return [
        each.name
        for each in parameters
        if any(kind in str(each.annotation) for kind in ARRAYS) and "Callable" not in str(each.annotation)
    ]


def test_no_array_of_a_public_function_is_left_out() -> None:
    protocols = ("Kinematics.", "Planner.", "Sampled.", "Stock.")
    wanted = {
        f"{name}: {argument}"
        for name, thing in public()
        if name not in (*RESULTS, *SHARES, *BETWEEN_ROOMS, *LIVE) and not name.startswith(protocols)
        for argument in arrays_of(thing)
    }
    assert len(wanted) > 60
    assert wanted - CASES.keys() == set()
    assert CASES.keys() - wanted == set()


def kinds(clean: np.ndarray) -> dict[str, Any]:
    """The same numbers in other clothes."""
    double = np.repeat(clean, 2, axis=0)
    unaligned = np.frombuffer(b"\0" + clean.tobytes(), dtype=np.uint8)[1:].view(clean.dtype).reshape(clean.shape)
    found = {
        "Fortran": np.asfortranarray(clean),
        "strided": double[::2],
        "backwards": clean[::-1].copy()[::-1],
        "read-only": clean.copy(),
        "a list": clean.tolist(),
        "masked, nothing of it": np.ma.masked_array(clean),
        "unaligned": unaligned,
        "other byte order": clean.astype(clean.dtype.newbyteorder()),
        "a column of a table": np.stack([clean, clean], axis=-1)[..., 0],
    }
    if clean.dtype.kind == "f":
        found |= {"float32": clean.astype(np.float32), "longdouble": clean.astype(np.longdouble)}
        if (clean == np.rint(clean)).all():
            found |= {"integers": clean.astype(np.int32)}
    found["read-only"].flags.writeable = False
    return found


@pytest.mark.parametrize("name", CASES)
def test_the_same_numbers_in_any_kind_of_array_give_the_same_answer(name: str) -> None:
    case = CASES[name]
    clean = case.clean.copy()
    wanted = answer(case.call(clean))
    assert np.array_equal(clean, case.clean)
    for kind, value in kinds(case.clean).items():
        if kind in ("float32", "longdouble") and not np.array_equal(value.astype(float), case.clean):
            continue
        assert same(wanted, answer(case.call(value))), kind


def wrong(case: Case) -> dict[str, Any]:
    """What is no such array."""
    clean, marks = case.clean, case.clean.dtype.kind == "b"
    found = {
        "two deeper": clean[None, None],
        "a table of columns": np.stack([clean, clean], axis=-1),
        "complex": clean * 1j,
        "text": np.full(clean.shape, "x"),
        "a word": "x",
        "objects": np.full(clean.shape, None),
        "times": clean.astype(np.int64).astype("datetime64[s]"),
        "numbers for marks" if marks else "marks": clean.astype(float) if marks else np.ones(clean.shape, dtype=bool),
        "lists of different lengths": [[0.0], [0.0, 1.0]],
        "masked": np.ma.masked_array(clean, np.arange(clean.size).reshape(clean.shape) == 1),
        "a set": {1.0, 2.0},
        "a mapping": {"x": 1.0},
        "a function": np.sin,
    }
    if clean.ndim > 1 and not case.any_width:
        found |= {"a column more": np.concatenate([clean, clean[..., :1]], axis=-1), "a column less": clean[..., :-1]}
        found |= {"turned round": np.moveaxis(clean, -1, 0).copy(), "flat and short": clean.ravel()[:-1]}
        if np.array_equal(found["turned round"], clean):
            del found["turned round"]
    if not marks:
        for figure, allowed in ((np.nan, case.missing), (np.inf, case.endless), (-np.inf, case.endless)):
            if not allowed:
                spoiled = clean.astype(float)
                spoiled.flat[clean.size // 2] = figure
                found[str(figure)] = spoiled
    if not case.optional:
        found["None"] = None
    return found


@pytest.mark.parametrize("name", CASES)
def test_what_is_no_such_array_is_one_error_that_names_it(name: str) -> None:
    case = CASES[name]
    for kind, value in wrong(case).items():
        with pytest.raises(ToolpaceError) as caught:
            case.call(value)
            pytest.fail(f"{kind} was taken")
        text = str(caught.value)
        assert "\n" not in text and len(text) < 300, kind
        assert case.named in text or "joints" in text, (kind, text)


@pytest.mark.parametrize("name", CASES)
def test_no_rows_and_one_row_are_an_answer_or_one_error(name: str) -> None:
    case = CASES[name]
    for value in (case.clean[:0], case.clean[:1], case.clean[0], np.concatenate([case.clean, case.clean])):
        try:
            case.call(value)
        except ToolpaceError as error:
            assert "\n" not in str(error)


def test_one_pose_is_the_row_of_many() -> None:
    tip, axis = MACHINE.forward(POSES)
    for k in range(len(POSES)):
        one = MACHINE.forward(POSES[k])
        assert np.array_equal(one[0], tip[k]) and np.array_equal(one[1], axis[k])
        longer = MACHINE.forward(POSES[k], 0.2)
        np.testing.assert_array_equal(longer[0], MACHINE.forward(POSES, np.full(6, 0.2))[0][k])
        assert np.array_equal(MACHINE.axis_at(TURNS[k]), MACHINE.axis_at(TURNS)[k])
        assert np.array_equal(MACHINE.joints_at(TIPS[k], TURNS[k]), MACHINE.joints_at(TIPS, TURNS)[k])
        assert np.array_equal(MACHINE.tip_lever(TIPS[k], TURNS[k]), MACHINE.tip_lever(TIPS, TURNS)[k])
        solutions, pole = MACHINE.rotary_solutions(AXES)
        assert np.array_equal(MACHINE.rotary_solutions(AXES[k])[0], solutions[k])
        assert MACHINE.rotary_solutions(AXES[k])[1] == pole[k]


def test_more_and_less_joints_than_the_machine_has_are_refused() -> None:
    for width in (1, 2, 3, 4, 6, 7):
        with pytest.raises(
            ToolpaceError, match=r"machine xyzac-trunnion: q has shape .*; give real numbers \(n, 5\) or"
        ):
            MACHINE.forward(np.zeros((10, width)))
    with pytest.raises(ToolpaceError, match=r"tip has shape \(6, 3\) and rotary \(5, 2\); give as many rows of both"):
        MACHINE.joints_at(TIPS, TURNS[:5])
    with pytest.raises(ToolpaceError, match=r"rotary has shape \(6, 3\); give real numbers \(n, 2\) or \(2,\) \[rad\]"):
        MACHINE.joints_at(TIPS, TIPS)
    with pytest.raises(ToolpaceError, match=r"q\[1, 2\] is nan; give finite numbers"):
        MACHINE.forward(np.where(np.arange(10).reshape(2, 5) == 7, np.nan, 0.0))
    with pytest.raises(ToolpaceError, match=r"axis 0 has the length 2; divide it by its length"):
        MACHINE.rotary_solutions([[0.0, 0.0, 2.0]])
