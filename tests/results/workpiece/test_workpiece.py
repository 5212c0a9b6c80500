"""The workpiece of a report: its stock at any time is what an independent cut leaves, in Python and in the page."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import toolpace as tp
from tests.support.report_pages import Arrays, calculated, embedded, opened
from toolpace.cutting.tool_profile import ToolProfile
from toolpace.programs.reading.setup_file import load_setup
from toolpace.programs.tool_figures import ToolFigures
from toolpace.results.report import write_report
from toolpace.results.workpiece import stock_stages
from toolpace.results.workpiece import view as workpiece_view
from toolpace.results.workpiece.view import outline, view_of_plan

SLOTS = """(</script> & "slots")
G21 G90 G54
T1 M6
S6000 M3
G0 X-8 Y6 Z2
G1 Z-3 F2000
G1 X38
G0 Z2
T2 M6
S9000 M3
G0 X-8 Y20
G1 Z-5 F1500
G1 X20 F2500
G0 Z30
M30
"""
SHEET = """[stock]
box = [[0, 0, -10], [30, 26, 0]]
uncertainty = 0
[finished_part]
box = [[0, 0, -10], [30, 2, 0]]
[fixtures.jaw]
box = [[30, 5, -12], [40, 20, -6]]
[tools.1]
kind = "flat"
diameter = 8
flute_length = 12
teeth = 3
stick_out = 30
holder = [[20, 20, 20]]
[tools.2]
kind = "ball"
diameter = 6
flute_length = 12
teeth = 2
"""


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """A program that cuts two slots, its motion, what is seen of it, and its page."""
    folder = tmp_path_factory.mktemp("workpiece")
    (folder / "sheet.toml").write_text(SHEET)
    setup = load_setup(folder / "sheet.toml")
    machine = tp.Machine.load("xyzac-trunnion")
    toolpath = tp.read_text(SLOTS, machine, setup=setup)
    trajectory = tp.plan_program(toolpath, machine, effort="low").trajectory
    page = folder / "report.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stock_stages, "POINTS", 40)
        patch.setattr(workpiece_view, "CELLS", 80)
        write_report(page, trajectory, trajectory.sample(4e-3), toolpath, program=SLOTS.encode(), setup=setup)
        view = view_of_plan(trajectory, toolpath, setup)
    return SimpleNamespace(
        setup=setup, machine=machine, toolpath=toolpath, trajectory=trajectory, view=view, page=page
    )


def volume(triangles):
    """That of a closed mesh (n, 3, 3)."""
    return float(np.einsum("nc,nc->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2]))) / 6.0


def test_the_stock_at_any_time_is_what_an_exact_slot_leaves(shown):
    stages, at = shown.view.stages, shown.trajectory.at
    t = np.linspace(0.0, shown.trajectory.duration, 2001)
    tip = 1e3 * shown.machine.forward(at(t).q)[0]
    for k in np.random.default_rng(3).integers(0, stages.stages + 1, 15).tolist():
        passed = tip[t <= k * stages.duration / stages.stages]
        first = passed[(np.abs(passed[:, 1] - 6.0) < 0.01) & (passed[:, 2] < -2.99)]
        second = passed[(np.abs(passed[:, 1] - 20.0) < 0.01) & (passed[:, 2] < -4.99)]
        far = [float(each[:, 0].max(initial=-8.0)) for each in (first, second)]
        # a slot that ends in half a disc; one whose bottom is half a ball's width round, and ends in a quarter of it
        flat = 3.0 * sum_of_chords(far[0], 4.0, 30.0)
        ball = 2.0 * sum_of_chords(far[1], 3.0, 30.0) + sum(
            sum_of_chords(far[1], math.sqrt(max(9.0 - h**2, 0.0)), 30.0) * 0.05 for h in np.arange(0.025, 3.0, 0.05)
        )
        # edges are bevelled by half a cell of 0.75 mm
        left = 1e9 * volume(stages.surface(k)[0])
        assert left == pytest.approx(30.0 * 26.0 * 10.0 - flat - ball, abs=16.0)


def sum_of_chords(far, radius, end):
    """Area between 0 and `end` that a disc has passed whose centre comes from afar to x = far."""
    x = np.linspace(0.0, end, 601)
    beyond = x - far
    chord = np.where(beyond < 0.0, 2.0 * radius, 2.0 * np.sqrt(np.maximum(radius**2 - beyond**2, 0.0)))
    return float(np.trapezoid(chord, x))


def test_the_surface_is_closed_and_flat_faces_and_edges_are_where_they_are(shown):
    stages = shown.view.stages
    for stage in (0, stages.stages // 2, stages.stages):
        triangles, cut = stages.surface(stage)
        corners, names = np.unique(triangles.reshape(-1, 3).round(9), axis=0, return_inverse=True)
        faces = names.reshape(-1, 3)
        # each edge is passed as often in one direction as in the other
        ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        forth, back = (np.unique(each, axis=0, return_counts=True) for each in (ways, ways[:, ::-1]))
        assert all((a == b).all() for a, b in zip(forth, back))
        assert 1e3 * corners.min(axis=0) == pytest.approx([0.0, 0.0, -10.0], abs=0.01)
        assert 1e3 * corners.max(axis=0) == pytest.approx([30.0, 26.0, 0.0], abs=0.01)
        assert cut.any() == (stage > 0)


def test_the_page_makes_the_same_surface_in_any_order(shown):
    stages = shown.view.stages
    asked = [stages.stages, 0, stages.stages // 3, stages.stages // 2, 0]
    found = calculated(
        shown.page.read_text(encoding="utf-8"),
        f"""const stock = new Stock(player.workpiece.stock, player.arrays);
        return {asked}.map((stage) => {{
            const {{ corners, triangles, cut }} = stock.surface(stage);
            return [Array.from(corners), Array.from(triangles), cut.reduce((a, b) => a + b, 0)];
        }});""",
    )
    for stage, (corners, triangles, cut) in zip(asked, found):
        mesh = np.array(corners).reshape(-1, 3)[np.array(triangles).reshape(-1, 3)]
        mine = 1e3 * stages.surface(stage)[0]
        assert len(mesh) == len(mine)
        # the page splits squares along the other order of corners
        assert np.allclose(np.sort(mesh.mean(axis=1), axis=0).mean(axis=0), mine.mean(axis=(0, 1)), atol=2e-3)
        assert volume(mesh) == pytest.approx(volume(mine), abs=1.0)
        assert (cut > 0) == (stage > 0)


def test_a_coarse_surface_is_closed_within_the_same_box_and_has_a_quarter_of_the_triangles(shown):
    stages = shown.view.stages
    asked = [0, stages.stages // 2, stages.stages]
    found = calculated(
        shown.page.read_text(encoding="utf-8"),
        f"""const stock = new Stock(player.workpiece.stock, player.arrays);
        return {asked}.map((stage) => {{
            const {{ corners, triangles }} = stock.surface(stage, true);
            return [Array.from(corners), Array.from(triangles), stock.surface(stage).triangles.length];
        }});""",
    )
    for stage, (corners, triangles, fine) in zip(asked, found):
        places, faces = np.array(corners).reshape(-1, 3), np.array(triangles).reshape(-1, 3)
        ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        forth, back = (np.unique(each, axis=0, return_counts=True) for each in (ways, ways[:, ::-1]))
        assert all((a == b).all() for a, b in zip(forth, back))
        assert places.min(axis=0) == pytest.approx([0.0, 0.0, -10.0], abs=0.02)
        assert places.max(axis=0) == pytest.approx([30.0, 26.0, 0.0], abs=0.02)
        # cells of 1.5 mm, of which the edges of two slots are bevelled by a half
        assert volume(places[faces]) == pytest.approx(1e9 * volume(stages.surface(stage)[0]), rel=0.02)
        assert 0.2 * fine < len(triangles) < 0.3 * fine


def test_tracks_are_those_of_the_slots(shown):
    tracks = {each.name: each.values for each in shown.view.tracks.tracks}
    # 8 mm wide and 3 mm deep at F2000 of the sheet's tool 1: 48 cm3/min; a third of F over the turns
    assert np.median(tracks["removal rate"][tracks["removal rate"] > 30.0]) == pytest.approx(48.0, rel=0.03)
    assert tracks["width"].max() == pytest.approx(8.0, abs=0.25)
    assert tracks["depth"].max() == pytest.approx(5.0, abs=0.25)
    assert tracks["chip"][tracks["width"] > 7.5].max() == pytest.approx(2000.0 / 6000.0 / 3.0 * 1e3, rel=0.02)
    assert {0, 1, 3} <= set(shown.view.tracks.state.tolist())


def test_an_outline_is_that_of_the_tool():
    profile = ToolProfile.of(ToolFigures("bull", 12e-3, corner_radius=3e-3, flute_length=20e-3))
    heights, radii = outline(profile.cutting).T
    assert heights[0] == 0.0 and heights[-1] == pytest.approx(20e-3)
    assert radii[0] == pytest.approx(3e-3) and radii.max() == pytest.approx(6e-3)
    bow = heights < 3e-3
    assert np.hypot(heights[bow] - 3e-3, radii[bow] - 3e-3) == pytest.approx(3e-3)


def test_a_stock_that_cannot_be_cut_is_a_word_on_the_page_and_no_error(shown, tmp_path):
    (tmp_path / "far.toml").write_text(SHEET.replace("[[0, 0, -10], [30, 26, 0]]", "[[900, 0, -10], [930, 26, 0]]"))
    (tmp_path / "bare.toml").write_text(SHEET[: SHEET.index("[tools.1]")])
    for name, word in (("far.toml", "mm away"), ("bare.toml", "[tools.1]")):
        setup = load_setup(tmp_path / name)
        page = tmp_path / f"{name}.html"
        write_report(page, shown.trajectory, shown.trajectory.sample(1e-2), shown.toolpath, setup=setup)
        text = page.read_text(encoding="utf-8")
        assert "The stock is not shown" in text and word in text
        assert embedded(text)["workpiece"]["stock"] is None


def test_a_sheet_without_bodies_shows_none(shown):
    assert view_of_plan(shown.trajectory, shown.toolpath, tp.SetUp()) is None


@pytest.mark.sweep
def test_the_browser_shows_stock_and_layers(shown):
    data = embedded(shown.page.read_text(encoding="utf-8"))
    assert len(Arrays(data).numbers(data["workpiece"]["part"])) == 9 * 12
    with opened(shown.page, 700, 500) as page:
        triangles = "(() => window.toolpace.state().stock)()"
        page.run("window.toolpace.seek(0)")
        assert page.run(triangles) == 0
        page.run(f"window.toolpace.seek({shown.trajectory.duration})")
        assert page.run(triangles) == shown.view.stages.stages
        page.run(f"window.toolpace.seek({0.5 * shown.trajectory.duration})")
        assert page.run(triangles) == shown.view.stages.stages // 2
        for layer, pressed in (("stock", "true"), ("part", "false"), ("fixtures", "true")):
            button = page.page.locator(f'[data-layer="{layer}"]')
            assert button.is_visible() and button.get_attribute("aria-pressed") == pressed
            button.click()
            assert button.get_attribute("aria-pressed") != pressed
        assert page.problems == [] and page.requests == [shown.page.resolve().as_uri()]
