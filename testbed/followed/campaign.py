"""Followers of random figures, and all that may be measured and asked for while they run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.followed.cases import CASES, RESERVES, case
from testbed.followed.disturbed import disturbed, figures
from testbed.followed.drive import driven
from testbed.followed.judge import Verdict, judged
from toolpace.deflection.following import Follower

RUNS_EACH = 10
"""Runs with one set of figures."""
SHORTEST, LONGEST = 5.0, 20.0
"""Time of a run in which anything happens [s]."""
CALM = 60.0
"""Time after that in which the path must be gone through [s]."""


def campaign(
    runs: int, seed: int, names: tuple[str, ...] = tuple(CASES), each: int = RUNS_EACH, longest: float = LONGEST
) -> Iterator[tuple[str, int, int, float, Verdict]]:
    """Name, seed, number, seconds of each run, and the verdict."""
    for group in range(-(-runs // each)):
        random = np.random.default_rng([seed, group])
        followed = case(names[group % len(names)], float(random.choice(RESERVES)))
        chosen = figures(random)
        follower = Follower(followed.trajectory, followed.machine, **chosen)
        for number in range(min(each, runs - group * each)):
            seconds = random.uniform(min(SHORTEST, longest), longest)
            count = int(seconds / follower.period)
            happens = disturbed(random, count, follower.period, chosen["max_correction"])
            out = driven(follower, happens, CALM)
            yield (
                followed.name,
                group,
                number,
                len(out) * follower.period,
                judged(follower, followed, happens.override, out),
            )
