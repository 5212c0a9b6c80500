"""Pictures of a plan: bodies and the tool are where the machine says, the nearer hides the farther, files are whole."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest

import toolpace as tp
from toolpace.cli import main
from toolpace.cli.commands.picture import Film, write_video
from toolpace.machine.machine import Machine
from toolpace.results.picture import draw
from toolpace.results.picture.draw import VIEWS, ShownPlan, picture
from toolpace.results.picture.rasteriser import Canvas
from toolpace.results.picture.solids import bodies_at, box, cylinder, machine_bodies, origin_of
from toolpace.results.report.machine_view import machine_view

PROGRAM = """G21 G90 G54
T1 M6
G43 H1
G0 X-8 Y6 Z12
G1 Z-3 F3000
G1 X38
G0 Z40
M30
"""
SHEET = """[stock]
box = [[0, 0, -10], [30, 26, 0]]
uncertainty = 0
[fixtures.jaw]
box = [[30, 5, -12], [40, 20, -6]]
[tools.1]
kind = "flat"
length = 90
diameter = 8
flute_length = 12
stick_out = 30
holder = [[20, 20, 20]]
"""


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """The folder of a plan, and what is shown of it."""
    place = tmp_path_factory.mktemp("picture")
    (place / "slot.ngc").write_text(PROGRAM)
    (place / "sheet.toml").write_text(SHEET)
    words = ["plan", str(place / "slot.ngc"), "-m", "xyzac-trunnion", "--setup", str(place / "sheet.toml")]
    assert main([*words, "--effort", "low", "--no-report", "--out", str(place / "plan")]) == 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draw, "PATH_POINTS", 1500)
        shown = ShownPlan.load(place / "plan", points=30)
        assert shown.path[0].shape == (1500,)
    return SimpleNamespace(place=place, shown=shown)


def test_a_triangle_covers_its_area_and_the_nearer_hides_the_farther():
    canvas = Canvas(80, 60, (0.0, 0.0, 0.0))
    # counterclockwise seen from the front, y downwards
    near = np.array([[[10.0, 50.0, 1.0], [70.0, 50.0, 1.0], [10.0, 10.0, 1.0]]])
    far = near + np.array([4.0, 4.0, 1.0])
    canvas.triangles(near, np.array([[1.0, 0.0, 0.0]]))
    canvas.triangles(far, np.array([[0.0, 1.0, 0.0]]))
    canvas.triangles(near[:, ::-1], np.array([[0.0, 0.0, 1.0]]))
    red, green, blue = canvas.pixels().reshape(-1, 3).T / 255.0
    assert red.sum() == pytest.approx(1200.0, rel=0.005)
    # of the farther one what is not behind: a triangle less one alike, of 54 in place of 60
    assert green.sum() == pytest.approx(1200.0 * (1.0 - 0.9**2), rel=0.01)
    assert blue.max() == 0.0
    canvas.lines(np.array([[[0.0, 30.0, 1.0], [79.0, 30.0, 1.0]]]), np.array([[1.0, 1.0, 1.0]]), 2.0, 0.1)
    assert canvas.pixels()[30, 20].tolist() == [255, 255, 255]


def test_slanted_faces_hide_each_other_where_they_cross():
    canvas = Canvas(100, 100, (0.0, 0.0, 0.0))
    square = np.array([[0.0, 100.0], [100.0, 100.0], [100.0, 0.0], [0.0, 0.0]])
    for colour, depth in (([1.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0]), ([0.0, 1.0, 0.0], [0.7] * 4)):
        corners = np.column_stack([square, depth])
        canvas.triangles(corners[[[0, 1, 2], [0, 2, 3]]], np.array([colour, colour]))
    shown = canvas.pixels()
    assert (shown[:, :69, 0] == 255).all() and (shown[:, 71:, 1] == 255).all()


@pytest.mark.parametrize("name", Machine.names())
def test_bodies_move_as_the_machine_does(name):
    machine = tp.Machine.load(name)
    view = machine_view(machine)
    low, high = (np.array([limit for limit, _ in each]) for each in (machine.travel, machine.travel[:, ::-1]))
    for q in np.random.default_rng(1).uniform(np.maximum(low, -3.0), np.minimum(high, 3.0), (5, len(low))):
        tip, axis = machine.forward(q[None], np.array([machine.tool_length]))
        part = (bodies_at(view["workpiece"], q) or [np.eye(4)])[-1] @ origin_of(view)
        tool = (bodies_at(view["tool_chain"], q) or [np.eye(4)])[-1]
        foot = 1e-3 * np.array(view["nose"]) - machine.tool_length * np.array(view["axis"])
        seen = np.linalg.solve(part, tool @ [*foot, 1.0])
        assert seen[:3] == pytest.approx(tip[0], abs=1e-12)
        assert np.linalg.solve(part, tool @ [*view["axis"], 0.0])[:3] == pytest.approx(axis[0], abs=1e-12)
    assert {each.chain for each in machine_bodies(view, np.zeros(3), np.full(3, 0.1))} == {"workpiece", "tool_chain"}


def test_solids_are_closed_and_turn_outwards():
    def volume(triangles):
        return float(np.einsum("nc,nc->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2]))) / 6.0

    z = np.array([0.6, 0.0, 0.8])
    facets = 48 / (2 * np.pi) * np.sin(2 * np.pi / 48)
    assert volume(cylinder(np.ones(3), z, 2.0, 3.0)) == pytest.approx(12.0 * np.pi * facets)
    assert volume(box(np.ones(3), np.array([0.8, 0.0, -0.6]), z, (1.0, 2.0, 3.0))) == pytest.approx(6.0)


def test_the_tool_and_the_slot_are_where_the_motion_says(planned):
    shown, size = planned.shown, (300, 240)
    t = 0.6 * shown.duration
    (tip,), _ = shown.tool_at(np.array([t]))
    assert 0.0 < tip[0] < 30e-3 and tip[2] == pytest.approx(-3e-3, abs=1e-5)
    low, high = shown.bounds
    front, top = (picture(shown, t, view, size).astype(int) for view in ("front", "top"))

    def pixel(shown_in, view, point):
        axes = draw.direction_axes(view)
        corners = np.array([[(low, high)[k >> d & 1][d] for d in range(3)] for k in range(8)]) @ axes[:2].T
        scale = (np.array(size) / (np.ptp(corners, axis=0) * draw.MARGIN)).min()
        x, y = scale * (axes[:2] @ (np.array(point) - 0.5 * (low + high)))
        return shown_in[round(size[1] / 2 - y), round(size[0] / 2 + x)]

    # the tool is yellow above the stock, and the face of the stock hides it below
    edge = pixel(front, "front", tip + np.array([0.0, 0.0, 6e-3]))
    assert edge[0] > edge[2] + 60
    face = pixel(front, "front", tip + np.array([0.0, 0.0, -2e-3]))
    assert abs(face[0] - face[2]) < 60
    # behind the tool the floor of the slot is bright, before it the raw stock is dark
    cut, raw = (pixel(top, "top", [x, 3.5e-3, 0.0]) for x in (tip[0] - 15e-3, tip[0] + 12e-3))
    assert cut.sum() > raw.sum() + 120


def test_every_view_of_the_machine_and_the_part_can_be_drawn(planned):
    pictures = {view: picture(planned.shown, 0.5, view, (96, 72)) for view in VIEWS}
    assert all(each.shape == (72, 96, 3) and each.std() > 5.0 for each in pictures.values())
    assert len({each.tobytes() for each in pictures.values()}) == len(VIEWS)


def test_files_are_what_was_asked_for(planned, tmp_path, capsys):
    image = pytest.importorskip("PIL.Image")
    plan = str(planned.place / "plan")
    assert main(["picture", plan, "--at", "0.5s", "--size", "120x90", "-o", str(tmp_path / "x.png")]) == 0
    with image.open(tmp_path / "x.png") as still:
        assert still.size == (120, 90) and still.format == "PNG"
    words = ["picture", plan, "--size", "96x72", "--seconds", "0.5s", "--to", str(tmp_path / "x.gif")]
    assert main(words) == 0
    with image.open(tmp_path / "x.gif") as moving:
        assert moving.size == (96, 72) and moving.n_frames == 5
    assert str(tmp_path / "x.gif") in capsys.readouterr().out.replace("\n", "")


def test_a_video_shows_the_moments_that_were_asked_for(planned, tmp_path, monkeypatch, capsys):
    av = pytest.importorskip("av")
    file, duration, told = tmp_path / "x.mp4", planned.shown.duration, []
    assert write_video(file, Film(planned.shown, (0.0, duration), 0.2, "iso", (96, 72)), told.append) == 5
    assert told == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])
    with av.open(str(file)) as video:
        frames = [each.to_ndarray(format="rgb24") for each in video.decode(video=0)]
    drawn = [picture(planned.shown, t, "iso", (96, 72)).astype(float) for t in np.linspace(0.0, duration, 5)]
    assert len(frames) == 5
    # lossy, with colours of two pixels each: nearer to its own moment than to any other
    for k, frame in enumerate(frames):
        off = [np.abs(frame - each).mean() for each in drawn]
        assert int(np.argmin(off)) == k and off[k] < 8.0
    words = ["picture", str(planned.place / "plan"), "--to", str(file), "--size"]
    assert main([*words, "97x72"]) == 2 and "even" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "av", None)
    assert main([*words, "96x72"]) == 2 and "toolpace[video]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ([], "give one of --out"),
        (["--to", "x.mpg"], "it ends with .gif or .mp4"),
        (["-o", "x.jpg"], "it ends with .png"),
        (["-o", "nowhere/x.png"], "folder does not exist"),
        (["-o", "x.png", "--view", "<b>"], "give one of iso"),
        (["-o", "x.png", "--size", "9x9"], "64 to 4000"),
        (["-o", "x.png", "--at", "1h"], "the motion ends at"),
        (["-o", "x.png", "--at", "soon"], "--at"),
    ],
)
def test_what_makes_no_sense_is_one_line(planned, tmp_path, monkeypatch, capsys, words, error):
    monkeypatch.chdir(tmp_path)
    assert main(["picture", str(planned.place / "plan"), *words]) == 2
    found = capsys.readouterr().err.strip()
    assert error in found and "\n" not in found
    assert list(tmp_path.iterdir()) == []
