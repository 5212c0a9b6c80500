"""What users hold: it compares and hashes without raising, shows itself in one line, and names public types only."""

from __future__ import annotations

import ast
import copy
import importlib
import inspect
import pickle
import types
import typing
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np
import pytest

import toolpace as tp
from toolpace.common.errors import UsageError
from toolpace.planning.planner import plan

MACHINE = tp.Machine.load("xyzac-trunnion")
PROGRAM = "G21 G90 G1 F1000\nX0 Y0 Z0 A0 C0\nX10 Y5\nX20 Y0 A5\nX30 Y-5 A10 C10\nM2\n"
LIMITS = tp.Limits([1.0, 2.0], [3.0, 4.0], [30.0, np.inf], ["one", "two"])


def wave(s: Any, order: int) -> Any:
    return np.stack([np.sin(s + order * np.pi / 2), 2.0**order * np.cos(2 * s + order * np.pi / 2)], axis=1)


def made() -> dict[str, Any]:
    """One of each object, made anew at each call from the same figures."""
    toolpath = tp.read_text(PROGRAM, MACHINE)
    path = tp.Path.fit(toolpath, machine=MACHINE)
    trajectory = tp.plan(path, MACHINE, mesh=200)
    points = trajectory.sample(1e-2)
    exact = tp.Path.paper_arc()
    run, law = trajectory.axis_path.runs[0], trajectory.laws[0]
    verification = tp.verify(points, MACHINE)
    return {
        "machine": tp.Machine.load("xyzac-trunnion"),
        "file": MACHINE.file,
        "geometry": MACHINE.geometry,
        "limits": tp.Limits([1.0, 2.0], [3.0, 4.0], [30.0, np.inf], ["one", "two"]),
        "tool path": toolpath,
        "path": path,
        "path run": path.runs[0],
        "jet": path.runs[0].evaluate(np.linspace(0.0, path.runs[0].s1, 5)),
        "exact path": exact,
        "exact run": exact.runs[0],
        "axis path": trajectory.axis_path,
        "axis run": run,
        "waypoints": tp.AxisPath.from_waypoints([[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]]),
        "function": tp.AxisPath.from_callable(wave),
        "law": law,
        "probe": next(iter(law.probes())),
        "trajectory": trajectory,
        "open places": trajectory.open_places,
        "usage": trajectory.usage(),
        "motion": trajectory.at([0.0, 0.1]),
        "set-points": points,
        "verification": verification,
        "check": verification.checks[0],
        "end state": tp.EndState(0.1, 0.2),
        "projection": tp.deflection.project(exact, [0.05, 0.05, 0.05]),
    }


ONE, OTHER = made(), made()
BY_VALUE = {
    "machine", "limits", "tool path", "motion", "set-points", "verification", "check", "end state", "projection",
    "usage",
}  # fmt: skip
COLLECTED = {"file"}
"""Records of msgspec: equal by value, and not hashable since they can be changed."""


@pytest.mark.parametrize("name", ONE)
def test_comparing_and_hashing_never_raise(name: str) -> None:
    one, other = ONE[name], OTHER[name]
    assert one == one and (one != one) is False
    assert isinstance(one == other, bool) and isinstance(one != other, bool)
    assert (one == other) is not (one != other)
    assert one != "something else" and one is not None
    if name not in COLLECTED:
        assert {one: 1}[one] == 1 and len({one, one}) == 1
        assert one != other or hash(one) == hash(other)


@pytest.mark.parametrize("name", sorted(BY_VALUE))
def test_the_same_figures_are_equal_and_hash_alike(name: str) -> None:
    assert ONE[name] == OTHER[name]
    assert hash(ONE[name]) == hash(OTHER[name])
    again = copy.deepcopy(ONE[name])
    assert again == ONE[name] and hash(again) == hash(ONE[name])


@pytest.mark.parametrize("name", ["path", "path run", "axis path", "axis run", "law", "trajectory", "jet"])
def test_what_holds_functions_is_equal_to_itself_alone(name: str) -> None:
    assert ONE[name] == ONE[name]
    assert ONE[name] != OTHER[name]


def test_other_figures_are_not_equal() -> None:
    assert LIMITS.scaled(jerk=1.01) != LIMITS
    assert tp.Limits([1.0], [1.0], [1.0], ["a"]) != tp.Limits([1.0], [1.0], [1.0], ["b"])
    assert MACHINE.with_tool(0.123) != MACHINE
    assert MACHINE.with_limits(MACHINE.limits.scaled(velocity=2.0)) != MACHINE
    toolpath = ONE["tool path"]
    assert toolpath != tp.read_text(PROGRAM.replace("X20", "X21"), MACHINE)
    assert ONE["set-points"] != ONE["trajectory"].sample(2e-2)


def test_machines_of_the_same_figures_are_equal_wherever_they_were_read() -> None:
    again = tp.Machine.from_toml(MACHINE.to_toml(), "elsewhere")
    assert again == MACHINE and hash(again) == hash(MACHINE)


def test_missing_figures_and_signs_of_zero_do_not_matter() -> None:
    nothing, again = (tp.Check("jerk", float("nan"), 0.0, "m", True) for _ in range(2))
    assert nothing == again and hash(nothing) == hash(again)
    plus, minus = (tp.Motion(*(np.array([zero, np.nan]) for _ in range(4))) for zero in (0.0, -0.0))
    assert plus == minus and hash(plus) == hash(minus)


def test_what_travels_between_processes_stays_equal() -> None:
    for name in ("machine", "limits", "tool path", "set-points", "verification", "usage"):
        assert pickle.loads(pickle.dumps(ONE[name])) == ONE[name]


@pytest.mark.parametrize("name", [name for name in ONE if name not in {"file", "geometry", "open places"}])
def test_every_object_says_in_one_line_what_it_is(name: str) -> None:
    text = repr(ONE[name])
    assert text.isprintable() and len(text) <= 120
    assert text.startswith(("<", "EndState(")) and type(ONE[name]).__name__ in text


def test_the_line_holds_what_matters() -> None:
    trajectory = ONE["trajectory"]
    line = repr(trajectory)
    assert f"{trajectory.duration:.6g} s" in line
    assert "5 joints X Y Z A C" in line and "block" in line and "gap" in line and "planner optimal" in line
    assert repr(LIMITS) == "<Limits of 2 joints one two>"
    assert repr(ONE["waypoints"]) == "<AxisPath 1 run, 2 joints q1 q2>"
    assert repr(ONE["axis path"]) == "<AxisPath 1 run, 5 joints X Y Z A C, machine xyzac-trunnion>"
    assert "every 10 ms" in repr(ONE["set-points"])
    assert "VERIFIED" in repr(ONE["verification"])
    assert "FAILED in 1 check" in repr(tp.Verification((tp.Check("jerk", 2.0, 1.0, "m/s^3", False),), 1e-3, 10))
    assert repr(tp.Verification((), 1e-3, 0)) == "<Verification VERIFIED, 0 checks of 0 set-points>"
    assert "program: " in repr(ONE["tool path"])
    usage = tp.Usage(0.5, {"X": 0.25, "Y": 0.75}, {"X": 0.875, "Y": 0.125}, {"X": 0.0, "Y": 1.0})
    assert repr(usage) == "<Usage of feed 0.5, velocity 0.75, acceleration 0.875, jerk 1>"


def test_without_a_bound_no_gap_is_shown() -> None:
    path = tp.AxisPath.from_callable(wave)
    assert "gap" not in repr(plan(path, LIMITS, mesh=50, bound=False))
    assert "gap" in repr(plan(path, LIMITS, mesh=50))


def test_a_line_computes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    path = tp.AxisPath.from_callable(wave)
    trajectory = plan(path, LIMITS, mesh=50, bound=False)
    monkeypatch.setattr(path.runs[0], "evaluate", None)
    assert "joints q1 q2" in repr(trajectory)
    assert "_judgement" not in vars(trajectory)


def test_names_of_strangers_do_no_harm() -> None:
    limits = tp.Limits(1.0, 1.0, 1.0, ["\x1b[31mred\n", "x" * 500, *map(str, range(100))])
    assert repr(limits).isprintable() and len(repr(limits)) <= 120
    toolpath = tp.read_text(PROGRAM, MACHINE, name="\x1b]0;\r\n" + "deep/" * 200 + "part.ngc")
    assert repr(toolpath).isprintable() and len(repr(toolpath)) <= 120
    assert "part.ngc: " in repr(toolpath)


# -- times --


def test_a_single_time_gives_one_row_less() -> None:
    trajectory = ONE["trajectory"]
    one, several = trajectory.at(0.1), trajectory.at([0.1])
    for part in ("q", "qd", "qdd", "qddd"):
        assert getattr(one, part).shape == (5,) and getattr(several, part).shape == (1, 5)
        np.testing.assert_array_equal(getattr(one, part), getattr(several, part)[0])
    assert trajectory.at(np.float64(0.1)).q.shape == trajectory.at(np.array(0.1)).q.shape == (5,)
    assert trajectory.at(0).qd.shape == (5,) and trajectory.at([]).q.shape == (0, 5)
    assert trajectory.parameter(0.1).shape == () and trajectory.parameter([0.1, 0.2]).shape == (2,)
    assert [part.shape for part in trajectory.tip(0.1)] == [(3,), (3,)]
    assert [part.shape for part in trajectory.tip([0.1, 0.2])] == [(2, 3), (2, 3)]
    assert trajectory.tip([])[0].shape == (0, 3)


@pytest.mark.parametrize("planner", ["optimal", "genetic", "second-order"])
def test_times_in_any_order_give_the_same_motion(planner: str) -> None:
    trajectory = plan(tp.AxisPath.from_callable(wave), LIMITS, planner=planner)
    t = np.linspace(-0.1, trajectory.duration + 0.1, 97)
    shuffled = np.random.default_rng(1).permutation(len(t))
    for part in ("q", "qd", "qdd", "qddd"):
        np.testing.assert_array_equal(
            getattr(trajectory.at(t[shuffled]), part), getattr(trajectory.at(t), part)[shuffled]
        )
    np.testing.assert_array_equal(trajectory.parameter(t[::-1]), trajectory.parameter(t)[::-1])


def test_the_machine_rests_before_and_after() -> None:
    motion = ONE["trajectory"].at([-np.inf, -1.0, 1e9, np.inf])
    assert not motion.qd.any() and not motion.qdd.any() and not motion.qddd.any()
    np.testing.assert_array_equal(motion.q[0], ONE["trajectory"].at(0.0).q)


@pytest.mark.parametrize(
    "time", [np.nan, "1.5", None, 1j, [0.1, np.nan], [[0.1, 0.2]], [0.1, "x"], [[0.1], [0.2, 0.3]]]
)
def test_what_is_no_time_is_one_error(time: Any) -> None:
    for ask in (ONE["trajectory"].at, ONE["trajectory"].parameter, ONE["trajectory"].tip, ONE["trajectory"].state):
        with pytest.raises(UsageError, match=r"trajectory: .*time") as caught:
            ask(time)
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 200


def test_a_state_is_that_of_one_time() -> None:
    with pytest.raises(UsageError, match="2 times where one is expected"):
        ONE["trajectory"].state([0.1, 0.2])


# -- signatures --


def namespace(module: types.ModuleType) -> dict[str, Any]:
    """All names that a module's annotations may use, those imported for type checking too."""
    names = dict(vars(module))
    for node in ast.walk(ast.parse(inspect.getsource(module))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module != "__future__":
            for alias in node.names:
                home = importlib.import_module(node.module)
                if not hasattr(home, alias.name):  # a module that nothing has imported so far
                    importlib.import_module(f"{node.module}.{alias.name}")
                names.setdefault(alias.asname or alias.name, getattr(home, alias.name))
    return names


def annotated(thing: Any) -> Iterator[tuple[str, Any]]:
    """(where, what holds annotations) of a public class or function: fields, methods, properties."""
    if not inspect.isclass(thing):
        yield thing.__qualname__, thing
        return
    for owner in thing.__mro__:
        if not owner.__module__.startswith("toolpace"):
            continue
        yield owner.__name__, owner
        for name, member in vars(owner).items():
            function = getattr(member, "__func__", None) or getattr(member, "fget", None) or member
            function = member.func if isinstance(member, cached_property) else function
            if inspect.isfunction(function) and (not name.startswith("_") or name == "__init__"):
                yield f"{owner.__name__}.{name}", function


def classes(hint: Any) -> Iterator[type]:
    """All classes inside a type."""
    if inspect.isclass(hint) and not isinstance(hint, types.GenericAlias):
        yield hint
    for part in typing.get_args(hint):
        yield from (one for item in (part if isinstance(part, list) else [part]) for one in classes(item))


def test_public_signatures_name_public_types_only() -> None:
    roots = {name: getattr(tp, name) for name in tp.__all__ if name not in ("__version__", "deflection")}
    roots |= {f"deflection.{name}": getattr(tp.deflection, name) for name in tp.deflection.__all__}
    public, hidden, seen = set(map(id, roots.values())), set(), 0
    for thing in roots.values():
        for where, holder in annotated(thing):
            own = vars(holder).get("__annotations__", {}) if inspect.isclass(holder) else holder.__annotations__
            shown = types.SimpleNamespace(__annotations__={k: v for k, v in own.items() if not k.startswith("_")})
            for name, hint in typing.get_type_hints(shown, namespace(inspect.getmodule(holder))).items():
                seen += 1
                found = (c for c in classes(hint) if c.__module__.startswith("toolpace") and id(c) not in public)
                hidden |= {f"{where}: {name}: {c.__module__}.{c.__qualname__}" for c in found}
    assert seen > 200
    assert hidden == set()
