"""The judge on random programs that confuse a matching: no false alarm, and no miss of a known amount."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from testbed.in_order_distance import distance_of_poses, within_in_order
from tests.support.walks import AXIS, MACHINE, PEAK, TIP, least_seconds, random_walk, set_points, without
from toolpace.judge import verify
from toolpace.programs.toolpath import no_rapids

NEAR = ("tip, ", "axis, ")
CLEAR = 0.02
"""Share of the tolerance about it within which nothing is asked: motion between set-points, chords of arcs."""


def findings(program, walk, **strays):
    """Names of the checks against the program that fail."""
    points, machine = set_points(walk, **strays)
    found = verify(points, machine, program, TIP, AXIS).findings
    judged = (*NEAR, "feed", "dwell", "stillness", "block column", "least time")
    return {check.what for check in found if check.what.startswith(judged)}, points


def oracle(program, points, radius):
    """Whether the motion is within so many tolerances of the program, in order, by the slow oracle."""
    poses = poses_of(points)
    kept = [0]
    for k in range(1, len(poses)):
        if k == len(poses) - 1 or np.abs(poses[k] - poses[kept[-1]]).max() > 0.1 * CLEAR * 6.0:
            kept.append(k)
    return within_in_order(poses[kept], chords(program), radius)


def poses_of(program):
    """Points of a program, or of a motion, as poses (n, 6)."""
    return np.hstack((program.tip / TIP, program.axis / AXIS))


def chords(program):
    """The program as a row of poses, turns in chords that are within a fifth of CLEAR of their arcs."""
    rows = [poses_of(program)[:1]]
    for k in range(1, len(program)):
        turn = np.abs(program.rotary[k] - program.rotary[k - 1])
        lean = np.sin(program.rotary[k - 1, 1]) if turn[1] == 0.0 else 1.0
        parts = int(np.ceil(turn.max() / np.sqrt(1.6 * CLEAR * AXIS / abs(lean)))) or 1
        u = (np.arange(parts) + 1.0)[:, None] / parts
        tip = program.tip[k - 1] + u * (program.tip[k] - program.tip[k - 1])
        rotary = program.rotary[k - 1] + u * (program.rotary[k] - program.rotary[k - 1])
        rows.append(np.hstack((tip / TIP, MACHINE.axis_at(np.ascontiguousarray(rotary)) / AXIS)))
    return np.concatenate(rows)


def right(seed):
    """No false alarm, on the line itself and at nine tenths of the tolerance beside it."""
    program, walk, r = random_walk(seed)
    assert findings(program, walk)[0] == set(), seed
    strays = {"wobble": 0.9, "phase": r.uniform(0.0, 3.0)}
    walk = replace(walk, seconds=1.5 * walk.seconds)
    found, points = findings(program, walk, **strays)
    if oracle(program, points, 1.0 - CLEAR):
        assert found == set(), seed


def off_the_line(seed):
    """A place that is off, a part left out, passes exchanged, a corner cut: as the oracle says."""
    program, walk, r = random_walk(seed)
    n = len(walk.poses)
    kind = r.integers(0, 4)
    i = int(r.integers(1, n))
    if kind == 0:
        direction = r.normal(0.0, 1.0, 5) * [1, 1, 1, 0, 0]
        far = r.choice([0.5, 1.05, 1.5, 3.0, 100.0]) * TIP
        walk = replace(walk, bumps=[(i, far * direction / np.linalg.norm(direction))])
    elif kind == 1:
        i = max(1, min(i, n - 2))
        walk = without(walk, i, int(r.integers(i + 1, n)))
    elif kind == 2:
        j = int(r.integers(1, n))
        poses = walk.poses.copy()
        poses[[i, j]] = poses[[j, i]]
        walk = replace(walk, poses=poses)
    else:
        i = max(1, min(i, n - 2))
        poses = walk.poses.copy()
        poses[i] += r.choice([0.002, 0.02, 0.5]) * (0.5 * (poses[i - 1] + poses[i + 1]) - poses[i])
        walk = replace(walk, poses=poses)
    seconds = least_seconds(walk.poses, np.full(len(walk.poses), 0.05))
    walk = replace(walk, seconds=1.2 * np.maximum(walk.seconds, seconds))
    found, points = findings(program, walk)
    off = {name for name in found if name.startswith(NEAR)}
    if oracle(program, points, 1.0 - CLEAR):
        assert not off, (seed, kind, found)
        return "near"
    if not oracle(program, points, 1.0 + CLEAR):
        assert off, (seed, kind)
        return "off"
    return "on the edge"


def out_of_pace(seed):
    """The feed of another pass, a dwell too short or elsewhere, a stop run over, a block misnamed."""
    program, walk, r = random_walk(seed)
    length = np.linalg.norm(np.diff(walk.poses[:, :3], axis=0), axis=1)
    kind = ("feed", "short dwell", "dwell elsewhere", "stop", "block")[r.integers(0, 5)]
    if kind == "feed":
        # the peak lies in the middle of the block, away from its neighbours
        seconds = walk.seconds.copy()
        seconds[1:] = np.maximum(PEAK * length / (r.choice([1.05, 1.5, 2.5]) * program.feed[1:]), 1e-9)
        blocks = np.flatnonzero((length > 30.0 * TIP) & (seconds[1:] > 0.03)) + 1
        if not len(blocks):
            return "nothing"
        changed = walk.seconds.copy()
        k = r.choice(blocks)
        changed[k] = seconds[k]
        assert "feed" in findings(program, replace(walk, seconds=changed))[0], seed
    elif kind in ("short dwell", "dwell elsewhere"):
        dwell, dwells = walk.dwell.copy(), np.flatnonzero(walk.dwell > 0.04)
        if not len(dwells):
            return "nothing"
        at = r.choice(dwells)
        dwell[at] *= 0.5 if kind == "short dwell" else 0.0
        if kind == "dwell elsewhere":
            others = np.flatnonzero(distance_of_poses(poses_of(program), poses_of(program)[at]) > 3.0)
            if not len(others):
                return "nothing"
            dwell[r.choice(others)] += walk.dwell[at]
        assert "dwell" in findings(program, replace(walk, dwell=dwell))[0], (seed, kind, at)
    elif kind == "stop":
        program, walk, stop = _with_a_stop_on_the_way(program, walk)
        if stop is None:
            return "nothing"
        assert findings(program, walk)[0] == set(), seed
        walk = replace(walk, flowing=frozenset([stop]))
        assert "stillness at stops" in findings(program, walk)[0], seed
    else:
        blocks = np.flatnonzero(length > 6.0 * TIP) + 1
        if not len(blocks):
            return "nothing"
        block = walk.block.copy()
        block[r.choice(blocks)] = r.choice([0, -1, 5, 10**6])
        assert findings(program, replace(walk, block=block))[0] == {"block column"}, seed
    return kind


def _with_a_stop_on_the_way(program, walk):
    """The same with the longest block cut in its middle, where the program stops."""
    length = np.linalg.norm(np.diff(walk.poses[:, :3], axis=0), axis=1)
    k = int(np.argmax(length)) + 1
    if length[k - 1] < 40.0 * TIP:
        return program, walk, None
    half = 0.5 * (walk.poses[k - 1] + walk.poses[k])
    poses = np.insert(walk.poses, k, half, axis=0)
    program = replace(
        program,
        tip=np.insert(program.tip, k, half[:3], axis=0),
        axis=MACHINE.axis_at(np.ascontiguousarray(poses[:, 3:])),
        feed=np.insert(program.feed, k, program.feed[k]),
        rapid=no_rapids(),
        least_time=np.zeros(len(poses)),
        block=np.insert(program.block, k, program.block[k]),
        stop=np.insert(program.stop, k, True),
        dwell=np.insert(program.dwell, k, 0.0),
        rotary=np.ascontiguousarray(poses[:, 3:]),
    )
    seconds = np.insert(walk.seconds, k, walk.seconds[k])
    dwell, block = np.insert(walk.dwell, k, 0.0), np.insert(walk.block, k, walk.block[k])
    return program, replace(walk, poses=poses, seconds=2.0 * seconds, dwell=dwell, block=block), k


@pytest.mark.parametrize("part", [0, *(pytest.param(part, marks=pytest.mark.sweep) for part in range(1, 4))])
def test_right_motions_are_passed(part):
    for seed in range(part, 40, 4):
        right(seed)


@pytest.mark.sweep
@pytest.mark.parametrize("count", [12, pytest.param(48, marks=pytest.mark.thorough)])
def test_motions_off_the_line_are_found(count):
    seen = Counter(off_the_line(seed) for seed in range(count))
    assert seen["off"] > 20 * count / 48 and seen["near"] > 8 * count / 48


@pytest.mark.sweep
def test_wrong_feeds_dwells_stops_and_blocks_are_found():
    seen = Counter(out_of_pace(seed) for seed in range(240))
    assert min(seen[kind] for kind in ("feed", "short dwell", "dwell elsewhere", "stop", "block")) > 10


@pytest.mark.parametrize(
    "part",
    [pytest.param(-1, marks=pytest.mark.sweep), *(pytest.param(k, marks=pytest.mark.thorough) for k in range(10))],
)
def test_thousands_of_walks(part):
    for seed in range(1000 + part, 4200, 10) if part >= 0 else range(5000, 5012):
        right(seed)
        off_the_line(seed)
        out_of_pace(seed)


def test_a_loop_is_not_judged_by_the_feed_of_its_next_pass():
    """To and fro on one line, each pass with a feed of its own: each is held to its own, and to no other."""
    program, walk, _ = random_walk(0)
    poses = np.tile([0.0, 0.0, 0.0, 0.3, 0.5], (4, 1))
    poses[[1, 3], 0] = 4e-3
    feed = np.array([np.inf, 0.1, 0.02, 0.1])
    rows = {name: np.zeros(4) for name in ("least_time", "dwell")}
    program = replace(
        program, tip=poses[:, :3].copy(), rotary=poses[:, 3:].copy(), axis=MACHINE.axis_at(poses[:, 3:].copy()),
        rapid=no_rapids(),
        feed=feed, block=np.arange(1, 5), stop=np.array([True, False, False, True]), **rows,
    )  # fmt: skip
    walk = replace(walk, poses=poses, seconds=least_seconds(poses, feed), dwell=np.zeros(4), block=np.arange(1, 5))
    assert findings(program, walk)[0] == set()
    for taken in ([np.inf, 0.1, 0.1, 0.1], [np.inf, 0.1, 0.02 * 1.05, 0.1]):
        assert findings(program, replace(walk, seconds=least_seconds(poses, np.array(taken))))[0] == {"feed"}
    # nor to that of the block beside it
    exchanged = replace(walk, seconds=least_seconds(poses, np.array([np.inf, 0.02, 0.1, 0.1])))
    assert findings(program, exchanged)[0] == {"feed"}


def test_each_dwell_has_time_of_its_own():
    """Three waits at one place, in three passes: the longest of them is not enough for all."""
    program, walk, _ = random_walk(0)
    poses = np.tile([0.0, 0.0, 0.0, 0.3, 0.5], (6, 1))
    poses[[1, 3, 5], 2] = -2e-3
    dwell = np.array([0.0, 0.1, 0.0, 0.3, 0.0, 0.2])
    feed = np.concatenate(([np.inf], np.full(5, 0.05)))
    program = replace(
        program, tip=poses[:, :3].copy(), rotary=poses[:, 3:].copy(), axis=MACHINE.axis_at(poses[:, 3:].copy()),
        rapid=no_rapids(),
        feed=feed, block=np.arange(1, 7), stop=dwell > -1.0, least_time=np.zeros(6), dwell=dwell,
    )  # fmt: skip
    walk = replace(walk, poses=poses, seconds=least_seconds(poses, feed), dwell=dwell, block=np.arange(1, 7))
    assert findings(program, walk)[0] == set()
    for wrong in ([0, 0, 0, 0.6, 0, 0], [0, 0.3, 0, 0.1, 0, 0.2], [0, 0.1, 0, 0.29, 0, 0.3], [0.6, 0, 0, 0.3, 0, 0.2]):
        assert "dwell" in findings(program, replace(walk, dwell=np.array(wrong)))[0], wrong


@pytest.mark.parametrize("kind", range(4))
def test_a_deviation_is_reported_at_its_place_and_as_large_as_it_is(kind):
    """25 micrometres off in the middle of one pass: no more, no less, and nothing else is found wrong behind it."""
    r = np.random.default_rng(kind)
    poses = np.tile([0.0, 0.0, 0.0, 0.3, 0.5], (12, 1))
    poses[:, 0] = np.arange(12) % 2 * 3e-3
    if kind % 2:
        poses[:, 1] = np.arange(12) * 1e-5
    feed = np.concatenate(([np.inf], r.choice([0.02, 0.05, 0.1], 11)))
    program, walk, _ = random_walk(0)
    program = replace(
        program, tip=poses[:, :3].copy(), rotary=poses[:, 3:].copy(), axis=MACHINE.axis_at(poses[:, 3:].copy()),
        rapid=no_rapids(),
        feed=feed, block=np.arange(1, 13), stop=np.arange(12) % 11 == 0, least_time=np.zeros(12), dwell=np.zeros(12),
    )  # fmt: skip
    seconds = 1.1 * least_seconds(poses, feed)
    way = 3 + kind
    bump = [(way, np.array([0.0, 0.0, 25e-6, 0.0, 0.0]))]
    walk = replace(walk, poses=poses, seconds=seconds, dwell=np.zeros(12), block=np.arange(1, 13), bumps=bump)
    points, machine = set_points(walk)
    found = verify(points, machine, program, TIP, AXIS)
    assert {check.what for check in found.findings if check.what.startswith(NEAR)} <= {
        "tip, set-points to program", "tip, program to set-points"
    }  # fmt: skip
    assert not {check.what for check in found.findings} & {"feed", "dwell", "stillness at stops", "block column"}
    assert found.tip_deviation == pytest.approx(25e-6, rel=0.02)
    worst = next(check for check in found.findings if check.what == "tip, set-points to program")
    assert worst.block == way + 1 and abs(worst.time - (seconds[: way + 1].sum() - 0.5 * seconds[way])) < 0.01
