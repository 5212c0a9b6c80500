"""Long runs: windows and pieces against one piece, limits across seams, memory, word of progress, Ctrl-C."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from testbed.long_path import long_path
from tests.support.random_paths import harmonics, random_limits
from tests.support.straight_line import line
from tests.support.usage import dense_usage
from toolpace.common.workers import CallersProgress, Workers
from toolpace.kernels.optimal import dual as kernel
from toolpace.kernels.optimal.newton import Ends
from toolpace.machine.limits import Limits
from toolpace.motion.laws import SplineLaw
from toolpace.path.axis_path import AxisPath
from toolpace.planning.bound import relaxation as bounds
from toolpace.planning.bound.relaxation import bound_long_run, bound_run
from toolpace.planning.limit_tolerances import GUARANTEE, PROMISED
from toolpace.planning.mesh.initial_guess import places
from toolpace.planning.mesh.nodes import first_mesh
from toolpace.planning.optimal import meshed_run, windows
from toolpace.planning.optimal.inter_sample_limits import within_guarantee
from toolpace.planning.optimal.meshed_run import MeshedRun
from toolpace.planning.optimal.planner import fastest_law
from toolpace.planning.optimal.slow_down import in_place, slowing
from toolpace.planning.planned_run import AT_REST, EndState
from toolpace.planning.planner import plan

CELLS = 9000
ROOT = Path(__file__).parents[3]


@pytest.fixture
def short_windows(monkeypatch):
    """What long runs are treated as, at lengths that are quickly solved in one piece too."""
    monkeypatch.setattr(meshed_run, "KEPT", 2000)
    monkeypatch.setattr(bounds, "WHOLE", 2000)
    monkeypatch.setattr(windows, "WINDOW", 2500)
    monkeypatch.setattr(bounds, "PIECE", 1500)


def in_one_piece(**options):
    path, limits = long_path(CELLS)
    return plan(path, limits, mesh=CELLS, **options)


@pytest.mark.parametrize("guard", [False, True])
def test_windows_lose_nothing_against_one_piece(guard, request):
    whole = in_one_piece(guard=guard)
    request.getfixturevalue("short_windows")
    assert in_one_piece(guard=guard).duration == pytest.approx(whole.duration, rel=1e-6)


def test_limits_hold_across_seams(short_windows):
    trajectory = in_one_piece()
    assert trajectory.usage().worst <= PROMISED
    assert dense_usage(trajectory, 100_000) <= PROMISED


def test_default_mesh_across_seams(short_windows):
    path, limits = long_path(20_000)
    trajectory = plan(path, limits)
    assert trajectory.mesh_points > 5000 and dense_usage(trajectory, 100_000) <= PROMISED


def test_breaks_and_caps_across_seams(short_windows):
    path, limits = long_path(CELLS)
    run = path.runs[0]
    breaks = np.linspace(run.s0, run.s1, 40)[1:-1]

    def cap(s):
        return np.where(np.searchsorted(breaks, s, "right") % 2, 0.5, 2.0)

    jumpy = AxisPath.from_callable(run.f, run.s0, run.s1, breaks=breaks, speed_cap=cap)
    trajectory = plan(jumpy, limits, mesh=CELLS)
    assert dense_usage(trajectory, 100_000) <= PROMISED
    assert 0.0 <= trajectory.gap < 0.02


def test_seams_leave_no_jump(short_windows):
    """The spline is of one piece: z'' is continuous at every knot."""
    law = in_one_piece().laws[0]
    step, cells = np.diff(law.nodes)[:-1], law.cells
    before = 2.0 * cells[:-1, 2] + 6.0 * cells[:-1, 3] * step
    assert np.abs(before - 2.0 * cells[1:, 2]).max() <= 1e-6 * np.abs(cells[:, 2]).max()


def cut(law, run, limits, shares):
    """A piece of a run between states of its law, and its own plan."""
    states = law.at(law.duration * np.array(shares))
    ends = [EndState(0.9 * float(v), 0.81 * float(a)) for v, a in states[1:3].T]
    f = run.f
    return AxisPath.from_callable(f, *states[0]).runs[0], *ends


def test_windows_between_ends_in_motion(short_windows):
    path, limits = long_path(CELLS)
    law, _ = fastest_law(path.runs[0], limits, cells=CELLS)
    run, start, end = cut(law, path.runs[0], limits, (0.05, 0.95))
    piece, _ = fastest_law(run, limits, cells=CELLS, start=start, end=end)
    assert piece.at(np.array([0.0]))[1, 0] == pytest.approx(start.speed, rel=1e-6)
    assert piece.at(np.array([piece.duration]))[1, 0] == pytest.approx(end.speed, rel=1e-6)
    found = bound_long_run(run, limits, piece, start, end)
    assert 0.0 < found.mesh_bound <= found.mesh_duration and found.gap < 1e-2


@pytest.mark.parametrize("guard", [False, True])
def test_bound_from_pieces_is_that_of_the_whole(guard, short_windows):
    path, limits = long_path(CELLS)
    law, _ = fastest_law(path.runs[0], limits, cells=CELLS, guard=guard)
    whole, pieces = bound_run(path.runs[0], limits, law), bound_long_run(path.runs[0], limits, law)
    assert pieces.mesh_duration == pytest.approx(whole.mesh_duration, rel=1e-12)
    assert pieces.mesh_bound == pytest.approx(whole.mesh_bound, rel=2e-5)


@pytest.mark.parametrize("seed", range(6))
def test_bound_from_pieces_is_never_above_the_best(seed, short_windows):
    """The unguarded plan obeys the rows at the nodes: no bound of that mesh may lie above its time."""
    path = AxisPath.from_callable(harmonics(seed, modes=30))
    law, _ = fastest_law(path.runs[0], random_limits(seed), cells=4000, guard=False)
    found = bound_long_run(path.runs[0], random_limits(seed), law)
    assert found.gap < 0.05 and found.mesh_bound <= found.mesh_duration


@pytest.mark.parametrize("seed", range(4))
def test_any_multipliers_of_pieces_give_a_bound(seed, short_windows, monkeypatch):
    """Pieces that give up at once are joined to a bound too, a weak one."""
    monkeypatch.setattr(bounds, "MOST_STEPS", 3 + seed)
    path, limits = long_path(CELLS)
    law, _ = fastest_law(path.runs[0], limits, cells=CELLS, guard=False)
    found = bound_long_run(path.runs[0], limits, law)
    assert found.mesh_bound <= found.mesh_duration


def test_gathered_multipliers_keep_kappa_positive_when_mixed():
    """Two sets that use up the time's weight, to its last bit, are mixed: the least value is not minus infinity."""
    rng = np.random.default_rng(0)
    n, rows = 50, rng.normal(size=(50, 4, 3))
    weight, none = rng.uniform(0.1, 1.0, n), np.zeros(n)
    basis = np.tile(np.eye(3)[[1, 0, 2]], (n, 1, 1))
    ends = Ends(np.zeros(2, dtype=np.int64), np.ones(2), np.zeros(4))
    knots = kernel.KnotRows(basis, np.arange(n + 1), weight, np.zeros(n + 2), rows, ends)
    sets = []
    for _ in range(2):
        dual = np.zeros((n, 4, 2))
        dual[:, 2:] = rng.exponential(size=(n, 2, 2))
        dual[:, 2:] *= (weight * rng.choice([1.0, 1.0 - 1e-14, 2.0], n) / dual.sum(axis=(1, 2)))[:, None, None]
        sets.append(kernel.gather(knots, none, dual, 8))
    for share in rng.uniform(size=20):
        mixed = share * sets[0] + (1.0 - share) * sets[1]
        _, kappa, _ = kernel.value_of(knots, none, np.ones(n), mixed, 8)
        assert (kappa >= 0.0).all()


def left_too_fast(by):
    """A run on its mesh, a law of it that is too fast by a share `by` of z at one place, and the usage in its cells."""
    path, limits = long_path(3000)
    run = path.runs[0]
    nodes, rough = first_mesh(run, limits, (0.0, 0.0), 3000)
    of_run = MeshedRun(run, limits, nodes, (AT_REST, AT_REST), rough.highest, (rough.s, rough.t), ramp=0.1)
    law, _ = fastest_law(run, limits, cells=3000)
    c = law.c.copy()
    c[1500:1503] *= 1.0 + by
    law = SplineLaw(law.nodes, c, law.rest)
    return of_run, law, of_run.look.peaks(law).used


def test_a_place_that_stays_above_is_eased_alone():
    of_run, law, peak = left_too_fast(2e-5)
    assert peak.max() > GUARANTEE
    slowed_down = within_guarantee(of_run, law, peak, Workers())
    assert of_run.look.peaks(slowed_down).used.max() <= GUARANTEE
    left = in_place(of_run.look, law, peak, of_run.ramp).left
    assert left[0] == left[-1] == 1.0 and left.min() < 1.0
    assert slowed_down.duration < law.slowed(slowing(peak)).duration


def test_mesh_of_a_path_without_hints_follows_its_turns():
    limits = random_limits(0)
    few = AxisPath.from_callable(harmonics(0)).runs[0]
    many = long_path(500_000)[0].runs[0]
    assert places(few, limits, 1500) == 1500 and places(line(1e9).runs[0], Limits([1.0], [3.0], [20.0]), 1500) == 1500
    assert places(many, limits, 1500) > 20_000


def test_hints_are_nodes():
    path, limits = long_path(5000, hints=True)
    nodes, _ = first_mesh(path.runs[0], limits, (0.0, 0.0), None)
    assert np.isin(path.runs[0].hints[1:-1], nodes).all()


def test_a_callers_function_is_asked_by_one_thread_at_a_time(short_windows):
    path, limits = long_path(CELLS)
    f, inside, together = path.runs[0].f, [0], [0]

    def watched(s, order):
        inside[0] += 1
        together[0] = max(together[0], inside[0])
        value = f(s, order)
        inside[0] -= 1
        return value

    plan(AxisPath.from_callable(watched, 0.0, path.runs[0].s1), limits, mesh=CELLS)
    assert together[0] == 1


@pytest.mark.parametrize("bound", [False, True])
def test_progress_within_a_run(bound, short_windows, monkeypatch):
    """There is word of each part of a run. Who asked hears it in his own thread, as far as he gets to listen."""
    words, seen, threads = [0.0], [], set()
    pass_on = CallersProgress.__call__

    def overheard(told, share):
        words.append(share)
        pass_on(told, share)

    def tell(share):
        seen.append(share)
        threads.add(threading.get_ident())

    monkeypatch.setattr(CallersProgress, "__call__", overheard)
    in_one_piece(bound=bound, progress=tell)
    assert len(set(words)) > 10 and np.diff(sorted(words)).max() < 0.6
    assert seen[-1] == 1.0 and seen == sorted(set(seen))
    assert threads == {threading.get_ident()}


def test_an_error_of_the_progress_callback_is_the_callers():
    def tell(share):
        if share > 0.3:
            raise RuntimeError("enough")

    before = threading.active_count()
    with pytest.raises(RuntimeError, match="enough"):
        plan(line(), Limits([1.0], [3.0], [20.0]), progress=tell)
    assert threading.active_count() == before


INTERRUPTED = """
import os, signal, sys, threading
from testbed.long_path import long_path
from toolpace import plan

under_way, shares = threading.Event(), [0.0]

def tell(share):
    shares.append(share)
    if share > float(sys.argv[1]):
        under_way.set()

def interrupt():
    under_way.wait()
    os.kill(os.getpid(), signal.SIGINT)

watcher = threading.Thread(target=interrupt)
watcher.start()
path, limits = long_path(80_000)
try:
    plan(path, limits, mesh=80_000, progress=tell)
except KeyboardInterrupt:
    watcher.join()
    print("interrupted", shares[-1] < 1.0, threading.active_count())
"""


@pytest.mark.parametrize("after", [pytest.param(0.04, marks=pytest.mark.sweep), 0.3])
def test_ctrl_c_in_the_middle_of_a_long_plan(after):
    """It is met well before the end, and leaves no thread behind."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, str(after)], cwd=ROOT, capture_output=True, text=True, timeout=600
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted True 1\n", "")


@pytest.mark.sweep
def test_memory_of_a_long_run():
    """A kilobyte a node would be 200 MB: rows of the whole run, with all that goes with them, would take more."""
    script = """
import resource
from testbed.long_path import long_path
from toolpace import plan
def most(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
for cells in (20_000, 200_000):
    path, limits = long_path(cells)
    trajectory = plan(path, limits, mesh=cells)
    assert trajectory.usage().worst <= 1.0001 and trajectory.gap < 1e-3
    print(most(), flush=True)
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, timeout=600)
    small, large = map(float, done.stdout.split())
    assert large - small < 180.0
