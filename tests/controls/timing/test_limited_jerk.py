"""The model `linuxcnc` with limited jerk against what LinuxCNC 2.10's planner (PLANNER_TYPE = 1) itself took.

Runs of its master of 22 August 2026 (commit 5c41560e) without a display, logged each millisecond: X, Y 500 mm/s,
4000 mm/s^2, 40 000 mm/s^3; Z 500, 3000, 30 000; B 120, 400, 4000 and C 180, 600, 6000 deg; path 500 mm/s,
40 000 mm/s^3. The model was written from its documents and source, and held against these afterwards.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from toolpace import Limits, Machine
from toolpace.common.errors import ProgramError
from toolpace.controls.timing.figures import figures_of
from toolpace.controls.timing.linuxcnc import LinuxCNC, linuxcnc_times
from toolpace.controls.timing.program_time import time_of_moves
from toolpace.programs.commanded import Commanded
from toolpace.programs.reading import ReadOptions, Source, read_commanded

LIMITS = {
    "X": (500, 4000, 4e4), "Y": (500, 4000, 4e4), "Z": (500, 3000, 3e4), "B": (120, 400, 4e3), "C": (180, 600, 6e3),
}  # fmt: skip
"""Of axes, in mm and degrees."""
HEAD = "G21 G90 G94 G17\nG64 P0.01 Q0.01\nG0 X0 Y0 Z0 B0 C0\n"
LIMITED = LinuxCNC(planner=1, path_velocity=500.0, path_jerk=4e4)
MEAN = 3.1e-3
"""A log is longer than the motion: means over three cycles, and one for the start; or shorter by the last [s]."""


def corner(degrees: float) -> str:
    turn = math.radians(degrees)
    return f"G1 X40 F6000\nX{40 + 40 * math.cos(turn):.6f} Y{40 * math.sin(turn):.6f}\n"


def chords(degrees: float) -> str:
    turn = np.radians(np.arange(degrees, 360.0 + 1e-9, degrees))
    return "G1 F6000\n" + "".join(f"X{20 * math.sin(a):.6f} Y{20 - 20 * math.cos(a):.6f}\n" for a in turn)


LOGGED = [
    (corner(10), 1.027, 0.0),
    (corner(30), 0.989, 0.0),
    (corner(90), 0.989, 0.0),
    (corner(150), 0.989, 0.0),
    (corner(170), 1.003, 0.0),
    ("G61\n" + corner(90), 1.002, 0.0),
    ("G3 X0 Y0 I20 J0 F6000\n", 4.496, 0.0),
    ("G3 X0 Y0 I5 J0 F6000\n", 2.259, 0.0),
    ("G3 X0 Y0 I1 J0 F6000\n", 1.019, 0.0),
    ("G1 X40 F6000\nG3 X50 Y10 I0 J10\nG1 Y50\n", 1.759, 0.0),
    ("G1 X20 F6000\nG3 X25 Y5 I0 J5\nG2 X30 Y10 I5 J0\nG1 X50\n", 1.692, 0.0),
    ("G1 X20 F6000\nX40 F1000\nX60 F12000\nX80 F3000\n", 2.143, 0.0),
    ("G1 X30 C30 F3000\nX60 C40\nX60 C80 F1000\n", 3.956, 0.0),
    (chords(2), 6.797, 4e-3),
]
"""Blocks, time of all moving cycles of the log [s], and the share by which the model is off beyond these cycles."""


def machine() -> Machine:
    own = Machine.load("xyzbc-trunnion")
    unit = np.where(own.is_rotary, math.pi / 180.0, 1e-3)
    velocity, acceleration, jerk = (np.array([LIMITS[j] for j in own.joints]) * unit[:, None]).T
    return own.with_limits(Limits(velocity, acceleration, jerk, own.joints))


def moves_of(blocks: str, head: str = HEAD, controller: Path | None = None) -> Commanded:
    source = Source.from_text(f"{head}{blocks}M2\n", "part.ngc")
    return read_commanded(source, machine(), options=ReadOptions.of(machine(), controller, None))


@pytest.mark.parametrize(("blocks", "seconds", "off"), LOGGED)
def test_a_logged_run_took_as_long(blocks: str, seconds: float, off: float):
    modelled = linuxcnc_times(moves_of(blocks), machine(), LIMITED).sum()
    assert -1.01e-3 - off * seconds <= seconds - modelled <= MEAN + off * seconds


def test_a_line_takes_an_s_curve():
    modelled = linuxcnc_times(moves_of("G1 X100 F6000\n"), machine(), LIMITED).sum()
    # the acceleration is not reached: 0.1 m/s in 2 (v / j)^(1/2)
    assert modelled == pytest.approx(1.0 + 2.0 * math.sqrt(0.1 / 40.0), abs=1e-9)


def test_a_lower_share_of_speeds_at_corners_is_never_faster():
    scaled = [LinuxCNC(planner=1, path_jerk=4e4, peak_scale=scale) for scale in (1.0, 0.5, 0.1)]
    polygon, corners = moves_of(chords(2)), moves_of(corner(90))
    full, half, least = (linuxcnc_times(polygon, machine(), each).sum() for each in scaled)
    assert 1.2 * full < half and 1.2 * half < least
    # as logged with R0.5: a corner that is overlapped keeps its time
    times = [linuxcnc_times(corners, machine(), each).sum() for each in scaled[:2]]
    assert times[0] == pytest.approx(times[1], abs=1e-9)


def test_the_program_or_the_figures_choose_the_planner(tmp_path: Path):
    newer = tmp_path / "newer.toml"
    newer.write_text('name = "newer"\nnote = "2.10"\nlike = "linuxcnc"\n[options]\nplanner_by_r = true\n')

    def total(head: str, **own: float) -> float:
        figures = figures_of({"linuxcnc": {"path_velocity": 500.0, "path_jerk": 4e4, **own}}, "", "linuxcnc")
        return time_of_moves(moves_of("G1 X40 F6000\nX40 Y40\n", head, newer), machine(), figures).total

    plain, limited = total(HEAD), total(HEAD, planner=1)
    assert plain < limited - 0.1
    assert total(HEAD.replace("Q0.01", "Q0.01 R1")) == pytest.approx(limited, abs=1e-12)
    assert total(HEAD.replace("Q0.01", "Q0.01 R0"), planner=1) == pytest.approx(plain, abs=1e-12)
    for word, share in (("R5", 1.0), ("R0.01", 0.1), ("R-1", 0.0)):
        assert moves_of("G1 X1 F60\n", HEAD.replace("Q0.01", word), newer).dynamics[-1, 3] == share
    with pytest.raises(ProgramError, match="R without a word that uses it"):
        moves_of("G1 X1 F60\n", HEAD.replace("Q0.01", "R1"))


def test_a_thousand_short_blocks_never_lose_their_order():
    rng = np.random.default_rng(5)
    place = np.cumsum(10.0 ** rng.uniform(-4, 0, (1000, 1)) * rng.normal(size=(1000, 3)), axis=0)
    blocks = "G1 F5000\n" + "".join("X{:.5f} Y{:.5f} Z{:.5f}\n".format(*row) for row in place)
    times = linuxcnc_times(moves_of(blocks), machine(), LIMITED)
    assert np.isfinite(times).all() and (times >= 0.0).all()
    assert times.sum() > linuxcnc_times(moves_of(blocks), machine()).sum()


@pytest.mark.parametrize("planner", [0, 1])
def test_blocks_that_come_back_to_where_they_began_take_no_time(planner: int):
    """A circle that is flatter than the tolerance is two lines; but for rounding these are joined to none."""
    settings, circle = LinuxCNC(planner=planner), "G2 X0.00055 Y0.01507 I0.00379 F700\n"
    blocks = f"G1 X0.00055 Y0.01507 F600\n{circle}G1 X4 Y5 F900\n"
    times = linuxcnc_times(moves_of(blocks), machine(), settings)
    without = linuxcnc_times(moves_of(blocks.replace(circle, "")), machine(), settings)
    assert times.sum() == pytest.approx(without.sum(), abs=2e-3)
