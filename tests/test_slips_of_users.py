"""Slips of those who use the library for the first time are refused by name; looser limits make no plan slower."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import toolpace as tp
from toolpace.cli import main
from toolpace.common.errors import UsageError
from toolpace.common.workers import Workers
from toolpace.cutting.tool_file import load_tool
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal.inter_sample_limits import at_least_as_fast
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.planner import held_law

MACHINE = tp.Machine.load("xyzac-trunnion")
POINTS = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0]]
LIMITS = tp.Limits(1.0, 5.0, 50.0, ["a", "b"])


def waves(phase: npt.NDArray[np.float64] | float = 0.0) -> tp.AxisPath:
    """Three joints along two waves; with no phases (2, 3) all of them stand where it begins."""
    w = np.array([4.02761312, 10.05890809])
    high = np.array([[0.20429216, -0.42679828, 0.2807663], [0.04222324, -0.1240463, -0.07350176]])
    begin = np.broadcast_to(phase, high.shape)

    def f(s: npt.NDArray[np.float64], order: int) -> npt.NDArray[np.float64]:
        angle = w[:, None, None] * np.asarray(s)[:, None] + begin[:, None, :] + 0.5 * np.pi * order
        return np.asarray((w[:, None, None] ** order * high[:, None, :] * np.cos(angle)).sum(axis=0))

    return tp.AxisPath.from_callable(f)


@pytest.mark.parametrize(
    "given", [None, "0.1", 0.1, [True], [0.1 + 0j], ["0.1"], [[0.1]], np.ma.array([0.1], mask=[True]), [10**400]]
)
def test_lengths_of_tools_are_numbers(given: object) -> None:
    with pytest.raises(UsageError, match="tool lengths"):
        MACHINE.with_tools(given)  # type: ignore[arg-type]


def test_lengths_of_tools_come_from_anything_that_gives_numbers() -> None:
    lengths = [0.1, 0.2, 0.1]
    for given in (lengths, tuple(lengths), np.array(lengths), iter(lengths)):
        machines = MACHINE.with_tools(given)
        assert [each.tool_length for each in machines] == lengths and machines[0] is machines[2]


@pytest.mark.parametrize("given", [None, "1", True, [1.0], np.nan, 1j, 10**400])
def test_a_place_that_is_passed_is_a_number(given: object) -> None:
    law = tp.plan(tp.AxisPath.from_waypoints(POINTS), LIMITS).laws[0]
    with pytest.raises(UsageError, match="passing_time: s"):
        law.passing_time(given)  # type: ignore[arg-type]
    assert law.passing_time(-np.inf) == 0.0 and law.passing_time(np.inf) == law.duration


def test_limits_in_another_order_than_the_joints_are_refused() -> None:
    """They were those of other joints, without a word."""
    path = tp.AxisPath.from_waypoints(POINTS, joints=["b", "a"])
    with pytest.raises(UsageError, match="limits are of the joints a, b, the path's are b, a"):
        tp.plan(path, LIMITS)
    other = tp.AxisPath.from_waypoints(POINTS, joints=["c", "d"])
    assert tp.plan(other, LIMITS).duration > 0.0


@pytest.mark.parametrize("given", [True, "1", None, 0.0, -1.0, np.nan, 10**400, 1j])
def test_a_speed_cap_is_a_number_or_a_function(given: object) -> None:
    with pytest.raises(UsageError, match=r"path: speed_cap is .* or a function of s"):
        tp.AxisPath.from_waypoints(POINTS, speed_cap=given)  # type: ignore[arg-type]


def test_a_parameter_whose_powers_overflow_is_refused() -> None:
    with pytest.raises(UsageError, match="waypoints: s goes to 1e"):
        tp.AxisPath.from_waypoints(POINTS, s=[0.0, 1.0, 1e300])


@pytest.mark.parametrize(
    ("time", "options", "message"),
    [
        (10**400, {}, "time 1e.300 s is not within"),
        (True, {}, "time is 'True'"),
        (0.3, {"interval": (0.0, 0.5)}, "interval is for a projection"),
        (0.3, {"rejoin": None}, "rejoin is None"),
    ],
)
def test_replanning_says_what_is_wrong(time: float, options: dict[str, object], message: str) -> None:
    planned = tp.plan(tp.AxisPath.from_waypoints(POINTS), LIMITS)
    with pytest.raises(UsageError, match=message):
        tp.replan(planned, time, [0.1, 0.1], most=1.0, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("given", [np.inf, 0.0, 1e300])
def test_a_normal_has_a_direction(given: float) -> None:
    toolpath = tp.read_text("G21 G90 G94\nG1 X0 Y0 Z0 A0 C0 F3000\nX30 A10 C20\n", MACHINE)
    normal = np.full((len(toolpath.tip), 3), np.nan)
    normal[1] = given
    with pytest.raises(UsageError, match="tool path: normal 1 has the length"):
        replace(toolpath, normal=normal)


@pytest.mark.parametrize(("word", "meant"), [("climb", "down"), ("conventional", "up"), ("slotting", "slot")])
def test_other_words_for_milling_are_understood(word: str, meant: str, tool_file: Callable[[str], str]) -> None:
    with pytest.raises(UsageError, match=f"milling = '{word}' is not known; did you mean '{meant}'"):
        load_tool(tool_file(word))


@pytest.fixture
def tool_file(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], str]:
    """A tool file with a word for its milling."""

    def written(word: str) -> str:
        path = tmp_path_factory.mktemp("tool") / "tool.toml"
        path.write_text(
            '[tool]\ndiameter = "4mm"\nteeth = 2\nstick_out = "40mm"\n[bending]\nyoungs_modulus = "580GPa"\n'
            '[cutting]\nspindle_speed = "18000rpm"\nspindle = "clockwise"\nKtc = "800MPa"\nKrc = "300MPa"\n'
            f'[engagement]\nmilling = "{word}"\naxial_depth = "8mm"\nradial_depth = "0.15mm"\n'
        )
        return str(path)

    return written


@pytest.mark.parametrize("factor", [1.0, 1.05, 2.0])
def test_without_jerk_limits_a_plan_is_no_slower_than_the_second_order_one(factor: float) -> None:
    """A finer mesh next to rest on which the solver found nothing ended the refinement: 0.17 percent slower."""
    path, limits = waves(), tp.Limits([1.1 * factor, 2.6 * factor, 1.4 * factor], [5.0, 9.0, 12.0], [np.inf] * 3)
    found = tp.plan(path, limits)
    assert found.duration < (1.0 + 1e-4) * tp.plan(path, limits, planner="second-order").duration
    assert max(found.usage().acceleration.values()) < 1.0 + 1e-4


def test_the_guard_mends_places_and_not_the_whole_run_where_jerk_has_no_limit() -> None:
    """With all of the duration as the time of a ramp, each round solved all anew and was led astray: 1.2 percent."""
    path = waves(np.array([[6.03303943, 4.45770189, 3.14006307], [1.2250801, 2.83418524, 0.71272698]]))
    limits = tp.Limits([2.19371607, 1.72859463, 1.26495612], [5.65695071, 13.56322274, 9.43962983], [np.inf] * 3)
    found = tp.plan(path, limits)
    assert found.duration < (1.0 + 1e-4) * tp.plan(path, limits, planner="second-order").duration
    assert found.duration < (1.0 + 1e-4) * tp.plan(path, limits, bound=False, guard=False).duration


def test_a_law_that_is_held_gives_way_to_a_faster_one() -> None:
    """Of an earlier round, slowed down to the guarantee."""
    path = waves()
    run, limits = path.runs[0], tp.Limits([1.1, 2.6, 1.4], [5.0, 9.0, 12.0], [50.0, 90.0, 120.0])
    rest = (tp.EndState(), tp.EndState())
    nodes, rough = first_mesh(run, limits, (0.0, 0.0), 300)
    law, _ = held_law(run, limits, 300, *rest, True, Workers())
    meshed = MeshedRun.after_guess(run, limits, nodes, rest, rough)
    used = meshed.look.peaks(law, Workers()).used
    assert at_least_as_fast(law.slowed(4.0), meshed, law, used, Workers()).duration <= law.duration * (1.0 + 1e-4)
    assert at_least_as_fast(law.slowed(0.5), meshed, law, used, Workers()).duration < law.duration


def test_where_machine_zero_is_a_stand_in_a_time_without_optimum_says_so_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "part.ngc").write_text("G21 G90\nG54\nG43.4 H1\nG1 X0. Y0. Z0. A0. C0. F2000\nX60. A10. C20.\nM30\n")
    (tmp_path / "sheet.toml").write_text("[offsets.G54]\nX = -120\nY = -50\nZ = -400\n")
    asked = ["time", str(tmp_path / "part.ngc"), "-m", "xyzac-trunnion", "--setup", str(tmp_path / "sheet.toml")]
    for more in ([], ["--no-optimum"]):
        assert main([*asked, *more]) == 2
        assert "say on a set-up sheet where machine zero" in " ".join("".join(capsys.readouterr()).split())
