"""A program with other feeds beside what was planned: its geometry, and the speed on each piece of each way."""

from __future__ import annotations

import numpy as np

from toolpace.controls.export.cut_feeds import FeedProgram
from toolpace.cutting.feeds.feed_plan import FeedPlan
from toolpace.cutting.feeds.schedule import Places
from toolpace.programs.toolpath import ToolPath

OFF_TIP, OFF_AXIS = 1e-6, 1e-5
"""How far a point at which a block is divided may be beside its straight way [m], [1]."""
ROUNDED = 5e-6
"""Way by which the end of a piece may be elsewhere than planned [m], and share by which a feed may be above."""


def random_plan(toolpath: ToolPath, seed: int) -> FeedPlan:
    """Feeds of all ways: some as they are, some slower, some faster; some change within a way."""
    rng = np.random.default_rng(seed)
    own, n = toolpath.most_speed, len(toolpath)
    own = np.where(np.isfinite(own) & ~toolpath.rapid, own, 0.0)
    x, origin = [np.arange(n, dtype=float)], [np.arange(n)]
    long = np.flatnonzero((toolpath.way_length > 20e-3) & (own > 0.0) & (rng.random(n) < 0.5))
    for k in long.tolist():
        inside = np.sort(rng.uniform(0.1, 0.9, 2))
        x.append(k - 1.0 + inside)
        origin.append(np.full(2, k))
    at = np.concatenate(x)
    order = np.argsort(at, kind="stable")
    at, of = at[order], np.concatenate(origin)[order]
    kind = rng.choice(4, len(at), p=[0.3, 0.15, 0.5, 0.05])
    factor = np.choose(kind, [1.0, rng.uniform(0.3, 1.0, len(at)), rng.uniform(1.0, 5.0, len(at)), 1.02])
    # one feed for most blocks
    same = np.isin(of, long, invert=True)
    by_block = rng.permutation(factor)[toolpath.block[of] % len(factor)]
    factor = np.where(same & (rng.random() < 0.7), by_block, factor)
    way = np.interp(at, np.arange(n), np.cumsum(toolpath.way_length))
    return FeedPlan((Places(at, way),), (factor * own[of],), ())


def check_new_feeds(toolpath: ToolPath, plan: FeedPlan, written: FeedProgram) -> int:
    """Assert that geometry is the same, and no speed above the plan but on lines that keep their text and are told.

    Returns how many lines the plan raises by more than 5 percent all along, or lowers.
    """
    new = written.toolpath
    at = points_of(toolpath, new)
    ends, feeds = plan.places[0].x, plan.feeds[0]
    begins = np.concatenate([ends[:1], ends[:-1]])
    kept_above = set()
    for k in range(1, len(new)):
        a, b = at[k - 1], at[k]
        line = int(toolpath.block[int(np.ceil(b))])
        if new.rapid[k] or b <= a or new.way_length[k] <= 0.0:
            continue
        way = toolpath.way_length[int(np.ceil(b))]
        slack = min(ROUNDED / way, 0.25 * (b - a))
        on = (ends > a + slack) & (begins < b - slack) & (ends > begins)
        least, own = feeds[on].min(), toolpath.most_speed[int(np.ceil(b))]
        if new.most_speed[k] > least * (1.0 + ROUNDED):
            assert np.isclose(new.most_speed[k], own, rtol=1e-9), f"line {line}: faster than allowed"
            kept_above.add(line)
    assert kept_above <= set(written.above), f"lines {sorted(kept_above - set(written.above))} are not told"
    return wanted(toolpath, plan)


def points_of(toolpath: ToolPath, new: ToolPath) -> np.ndarray:
    """(n,) where each point of a new path is on the old one, as a share of its points. Asserts the same geometry."""
    found, k = np.zeros(len(new)), 0
    for i in range(len(new)):
        same = k < len(toolpath) and (new.tip[i] == toolpath.tip[k]).all() and (new.axis[i] == toolpath.axis[k]).all()
        if same:
            assert new.rapid[i] == toolpath.rapid[k] and new.stop[i] == toolpath.stop[k]
            assert new.dwell[i] == toolpath.dwell[k]
            found[i] = k
            k += 1
            continue
        assert 0 < k < len(toolpath), f"point {i} is none of the program"
        begin, way = toolpath.tip[k - 1], toolpath.tip[k] - toolpath.tip[k - 1]
        share = float((new.tip[i] - begin) @ way / (way @ way))
        axis = toolpath.axis[k - 1] + share * (toolpath.axis[k] - toolpath.axis[k - 1])
        assert 0.0 < share < 1.0 and found[i - 1] < k - 1 + share
        assert np.linalg.norm(begin + share * way - new.tip[i]) <= OFF_TIP
        assert np.linalg.norm(axis - new.axis[i]) <= OFF_AXIS
        assert not new.rapid[i] and not new.stop[i] and new.dwell[i] == 0.0
        found[i] = k - 1 + share
    assert k == len(toolpath), "the new program ends early"
    return found


def wanted(toolpath: ToolPath, plan: FeedPlan) -> int:
    """How many lines get another feed, as far as their text can bear one."""
    ends, feeds = plan.places[0].x, plan.feeds[0]
    of = np.ceil(ends).astype(int)
    own = toolpath.most_speed[of]
    found = {}
    for k, line in enumerate(toolpath.block[of].tolist()):
        if own[k] > 0.0 and np.isfinite(own[k]) and not toolpath.rapid[of[k]]:
            found[line] = min(found.get(line, np.inf), feeds[k] / own[k])
    return sum(each < 1.0 - 1e-6 or each > 1.05 for each in found.values())
