"""The choice of rotary positions over a whole tool path."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.growth import NEARLY_LINEAR, order_of_growth, python_calls
from toolpace.common.errors import ReachError
from toolpace.machine.machine import Machine
from toolpace.programs.toolpath import ToolPath


def toolpath(tip: np.ndarray, axis: np.ndarray, feed: np.ndarray | float = 0.05, **more: object) -> ToolPath:
    n = len(axis)
    axis = axis / np.linalg.norm(axis, axis=1)[:, None]
    stop = np.zeros(n, dtype=bool)
    stop[[0, -1]] = True
    feeds = np.broadcast_to(feed, n).astype(float).copy()
    still = np.zeros(n)
    tips = np.broadcast_to(tip, (n, 3)).astype(float).copy()
    return ToolPath(tips, axis, feeds, still, np.arange(1, n + 1), stop, still.copy(), source="part.cls", **more)


def cone(tilt: np.ndarray | float, azimuth: np.ndarray) -> np.ndarray:
    tilt = np.broadcast_to(tilt, azimuth.shape)
    return np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)


@pytest.mark.parametrize("name", Machine.names())
def test_turns_run_on(name: str) -> None:
    """Eight turns about a cone: no jump, the axis exact, or where travel forbids it an error that says so."""
    machine = Machine.load(name)
    path = toolpath(np.zeros(3), cone(0.3, np.linspace(0, 16 * np.pi, 4000)))
    if name in ("xyzac-head", "xyzbc-head"):
        with pytest.raises(ReachError, match=r"part.cls:\d+: the rotary joints run out of travel \(C -360 .. 360 deg"):
            machine.choose_rotary(path)
        return
    rotary = machine.choose_rotary(path)
    np.testing.assert_allclose(machine.axis_at(rotary), path.axis, atol=1e-12)
    assert np.abs(np.diff(rotary, axis=0)).max() < 0.02
    # Only where the first joint turns about the upright axis does it turn with the cone.
    if name not in ("paper-ab", "xyzab-table"):
        assert abs(rotary[-1, 0] - rotary[0, 0]) == pytest.approx(16 * np.pi)


def test_start_turn_leaves_room() -> None:
    """Travel of two turns, one and a half needed: the start is chosen at the end of travel that leaves room."""
    machine = Machine.load("xyzbc-head")
    for way in (1.0, -1.0):
        path = toolpath(np.zeros(3), cone(0.3, way * np.linspace(0, 3.5 * np.pi, 3000)))
        rotary = machine.choose_rotary(path)
        assert np.abs(np.diff(rotary, axis=0)).max() < 0.02
        assert np.abs(rotary[:, 0]).max() <= 2 * np.pi


def test_tilt_on_one_side_only() -> None:
    """LinuxCNC's A runs from -100 to 50 degrees: beyond 50 there is one solution, and it is kept throughout."""
    machine = Machine.load("linuxcnc-xyzac-trt")
    rotary = machine.choose_rotary(toolpath(np.zeros(3), cone(np.linspace(0.3, 1.4, 500), np.linspace(0, 4, 500))))
    assert (rotary[:, 1] < 0).all() and np.abs(np.diff(rotary, axis=0)).max() < 0.02


def test_linear_travel_decides_between_solutions() -> None:
    """A part near the end of Y's travel: near home Y would pass 100 mm; with the table turned round it does not."""
    machine = Machine.load("linuxcnc-xyzac-trt")
    axis = cone(0.4, np.linspace(1.52, 1.62, 50))
    near = machine.choose_rotary(toolpath(np.zeros(3), axis))
    assert (near[:, 1] > 0).all()
    far = machine.choose_rotary(toolpath(np.array([0.0, 0.1045, 0.0]), axis))
    assert (far[:, 1] < 0).all()


def test_through_the_pole_by_least_motion() -> None:
    """An axis that tilts from one side to the other straight through the pole: A changes sign, C stands."""
    machine = Machine.load("xyzac-trunnion")
    tilt = np.linspace(-0.4, 0.4, 101)
    path = toolpath(np.zeros(3), np.stack([np.sin(tilt), 0 * tilt, np.cos(tilt)], axis=1))
    rotary = machine.choose_rotary(path)
    assert np.ptp(rotary[:, 0]) < 1e-12
    np.testing.assert_allclose(np.abs(np.diff(rotary[:, 1])), 0.008, atol=1e-12)


def test_free_joint_turns_evenly_while_at_the_pole() -> None:
    """Tilted about y, upright for a while, tilted about x: C turns its quarter over the upright stretch."""
    machine = Machine.load("xyzac-trunnion")
    down, up = np.linspace(0.4, 0.01, 40), np.linspace(0.01, 0.4, 40)
    axis = np.concatenate([cone(down, np.zeros(40)), cone(0.0, np.zeros(21)), cone(up, np.full(40, np.pi / 2))])
    tip = np.stack([np.linspace(0, 0.1, 101), np.zeros(101), np.zeros(101)], axis=1)
    rotary = machine.choose_rotary(toolpath(tip, axis))
    np.testing.assert_allclose(machine.axis_at(rotary), axis, atol=1e-12)
    assert abs(rotary[-1, 0] - rotary[0, 0]) == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(np.abs(np.diff(rotary[40:61, 0])), np.pi / 40, atol=1e-12)
    assert np.ptp(rotary[:40, 0]) < 1e-12 and np.ptp(rotary[61:, 0]) < 1e-12


def test_free_joint_rests_at_the_ends() -> None:
    machine = Machine.load("xyzac-trunnion")
    axis = np.concatenate([cone(0.0, np.zeros(5)), cone(np.linspace(0, 0.3, 20), np.full(20, 1.0))])
    rotary = machine.choose_rotary(toolpath(np.zeros(3), axis))
    assert np.ptp(rotary[:, 0]) < 1e-12
    assert machine.choose_rotary(toolpath(np.zeros(3), cone(0.0, np.zeros(4)))).tolist() == [[0.0, 0.0]] * 4


def test_noise_about_the_pole_is_no_motion() -> None:
    """An upright tool written with four decimals: the axis scatters by half a digit, the table stands still."""
    machine = Machine.load("xyzac-trunnion")
    rng = np.random.default_rng(9)
    axis = np.stack([*rng.uniform(-5e-5, 5e-5, (2, 200)), np.ones(200)], axis=1)
    path = toolpath(np.zeros(3), axis)
    rotary = machine.choose_rotary(path)
    assert np.ptp(rotary[:, 0]) == 0.0
    assert np.abs(machine.axis_at(rotary) - path.axis).max() < 1e-4


def test_given_rotary_positions_are_kept() -> None:
    machine = Machine.load("xyzac-trunnion")
    a, c = np.linspace(0, -1, 10), np.linspace(20, 30, 10)
    axis = machine.axis_at(np.stack([c, a], axis=1))
    path = toolpath(np.zeros(3), axis, rotary=np.stack([a, c], axis=1), rotary_joints=("A", "C"))
    np.testing.assert_array_equal(machine.choose_rotary(path), np.stack([c, a], axis=1))
    with pytest.raises(ReachError, match=r"part.cls:10: joint A would have to go to -57.296 deg, .* limit of -40 deg"):
        toml = machine.to_toml().replace("travel = [-130, 130]", "travel = [-40, 130]")
        Machine.from_toml(toml).choose_rotary(path)


def test_rewinding_on_a_rapid_is_allowed() -> None:
    """Five turns in two cuts with a rapid between: the fork rewinds on the rapid."""
    machine = Machine.load("xyzbc-head")
    axis = cone(0.3, np.linspace(0, 7 * np.pi, 2001))
    feed = np.full(2001, 0.05)
    feed[1000] = np.inf
    rotary = machine.choose_rotary(toolpath(np.zeros(3), axis, feed))
    jumps = np.abs(np.diff(rotary[:, 0])) > 1
    assert jumps.sum() == 1 and jumps[999]


@pytest.mark.parametrize(
    ("name", "tilt", "message"),
    [
        (
            "xyzbc-nutating",
            100.0,
            r"part.cls:2: unreachable tilt: .*100.000 deg to the axis of joint C; .*0.000 to 90.000",
        ),
        ("xyzac-trunnion", 150.0, r"part.cls:2: the tool axis needs C .*A 150.000.*A -130 .. 130 deg"),
        ("xyzbc-head", 120.0, r"part.cls:2: the tool axis needs C .*B 120.000.*B -110 .. 110 deg"),
    ],
)
def test_unreachable_tilt(name: str, tilt: float, message: str) -> None:
    with pytest.raises(ReachError, match=message):
        Machine.load(name).choose_rotary(toolpath(np.zeros(3), cone(np.radians([10.0, tilt]), np.zeros(2))))


def test_linear_travel_exceeded() -> None:
    path = toolpath(np.array([[0.0, 0, 0], [0.6, 0, 0]]), cone(0.0, np.zeros(2)))
    with pytest.raises(
        ReachError, match=r"part.cls:2: joint X would have to go to 600.000 mm, above its limit of 500 mm"
    ):
        Machine.load("xyzac-trunnion").choose_rotary(path)


def test_cost_is_in_compiled_loops_and_grows_in_proportion_to_the_points() -> None:
    machine = Machine.load("linuxcnc-xyzac-trt")

    def winding(n: int) -> ToolPath:
        s = np.linspace(0, 1, n)
        return toolpath(0.03 * np.stack([np.cos(9 * s), np.sin(9 * s), s], axis=1), cone(0.5 * np.sin(40 * s), 60 * s))

    few, many = winding(3_000), winding(30_000)
    assert np.abs(np.diff(machine.choose_rotary(many), axis=0)).max() < 0.02
    calls = [python_calls(lambda path=path: machine.choose_rotary(path)) for path in (few, many)]
    assert calls[1] == calls[0]
    assert order_of_growth(machine.choose_rotary, few, many, 10.0) < NEARLY_LINEAR
