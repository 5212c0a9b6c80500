"""A curve given exactly, not by a program: an arc with its tool axis, timed against what the feed alone would take."""

from __future__ import annotations

import math

import toolpace as tp


def main() -> tuple[float, float]:
    machine = tp.Machine.load("paper-ab")
    feed = 0.03  # [m/s]
    path = tp.Path.paper_arc(feed)
    trajectory = tp.plan(path, machine)
    by_feed = 0.1 * math.pi / 2.0 / feed
    print(f"feed alone {by_feed:.4f} s, with every limit {trajectory.duration:.4f} s")
    print(f"worst use of a limit {trajectory.usage().worst:.5f}")
    return by_feed, trajectory.duration


if __name__ == "__main__":
    main()
