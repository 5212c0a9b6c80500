"""A tool path with the feeds of a plan: points are put in where they change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from toolpace.cutting.feeds.schedule import AT_A_POINT, ends_of_pieces
from toolpace.cutting.prediction import with_points


def with_feeds(toolpath, machine, places, feeds):
    """The program with other feeds: on the way to each station of each stretch that of `feeds`.

    What no station speaks of keeps its own; times of blocks (G93) give way where the new feed is another than what they
    come to.
    """
    x, values = ends_of_pieces(places, feeds, toolpath.most_speed)
    if not len(x):
        return toolpath
    inserted = x[np.abs(x - np.round(x)) > AT_A_POINT]
    inserted = inserted[inserted < len(toolpath) - 1]
    at = np.concatenate([np.arange(len(toolpath), dtype=np.float64), inserted])
    at = at[np.argsort(at, kind="stable")]
    origin = np.ceil(at - AT_A_POINT).astype(np.int64)
    share = np.where(np.abs(at - origin) <= AT_A_POINT, 1.0, at - (origin - 1.0))
    dense = with_points(toolpath, machine, origin, share) if len(inserted) else toolpath
    middle = np.concatenate([[0.0], 0.5 * (at[1:] + at[:-1])])
    piece = np.searchsorted(x, middle, side="left")
    feed = np.append(values, np.nan)[np.minimum(piece, len(values))]
    known = np.isfinite(feed) & (feed > 0.0) & ~dense.rapid
    own = dense.most_speed
    changed = known & (np.abs(feed / np.where(known, own, 1.0) - 1.0) > 1e-9)
    return replace(
        dense,
        feed=np.where(changed, feed, dense.feed),
        least_time=np.where(changed, 0.0, dense.least_time),
    )
