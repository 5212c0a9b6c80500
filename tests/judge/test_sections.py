"""A motion that is aligned section by section has the places that it has when it is aligned at once."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.random_rows import HABITS, along, random_program, spoilt
from toolpace.judge.alignment import Lost, align
from toolpace.judge.alignment.sections import Sections, Steps
from toolpace.judge.alignment.sweep import Line
from toolpace.judge.rows import Stretch


def case(seed):
    """A motion, a program, more tolerance on some of its ways, and set-points at which sections begin."""
    r = np.random.default_rng(seed)
    program = random_program(r, HABITS[seed % len(HABITS)])
    motion = along(r, program, within=r.choice([0.3, 0.9, 1.0]), corners=r.random() < 0.5)
    if seed % 3 == 0:
        motion = spoilt(r, motion)
    if seed % 5 == 0:
        # it waits at some poses
        motion = np.repeat(motion, r.choice([1, 1, 1, 5], len(motion)), axis=0)
    if len(motion) < 4:
        motion = np.repeat(motion, 4, axis=0)
    room = r.choice([0.0, 0.0, 0.5, 2.0], (len(program) - 1, 2)) if seed % 2 else np.zeros((len(program) - 1, 2))
    count = min(len(motion) // 3, 1 + int(r.integers(8)))
    cuts = np.sort(r.choice(np.arange(1, len(motion) - 1), count, replace=False))
    return motion, program, room, np.concatenate(([0], cuts, [len(motion) - 1]))


def sections_of(motion, program, room, cuts, within, r):
    """The sections, taken in any order."""
    sections = Sections(Line(program, np.zeros(len(program)), room), within, len(motion) - 1)
    t = np.arange(float(len(motion)))
    for k in r.permutation(len(cuts) - 1):
        part = slice(cuts[k], cuts[k + 1] + 1)
        poses, none = motion[part], np.empty(0, dtype=np.int64)
        steps = len(poses) - 1
        block, speed = np.zeros(steps + 1, dtype=np.int64), np.zeros(steps + 2)
        sections.take(Steps(Stretch(poses, int(cuts[k]), None, none), t[part], block, speed))
    return sections


def places_of(alignment, pose, shift):
    part = slice(alignment.begin[pose], alignment.begin[pose + 1])
    return list(zip(alignment.low[part] + shift, alignment.high[part] + shift))


def union(places):
    """Places in order; those that touch as one."""
    found = []
    for low, high in sorted(places):
        if found and low <= found[-1][1] + 1e-9:
            found[-1][1] = max(found[-1][1], high)
        else:
            found.append([low, high])
    return found


def agrees(seed, within=1.0):
    motion, program, room, cuts = case(seed)
    r = np.random.default_rng(seed)
    whole = align(motion, program, within, np.zeros(len(motion)), room)
    sections = sections_of(motion, program, room, cuts, within, r)
    assert sections.follows == (not isinstance(whole, Lost) and not whole.deviations), seed
    if not sections.follows:
        return False
    there, back = [[] for _ in motion], [[] for _ in program]
    for section in sections.each(lambda each: each):
        first = section.program.start
        for pose in range(len(section.motion.poses)):
            there[section.begin + pose] += places_of(section.found.there, pose, first)
        for pose in range(len(section.found.back.place)):
            back[first + pose] += places_of(section.found.back, pose, section.begin)
    for rows, alignment in ((there, whole.there), (back, whole.back)):
        for pose, places in enumerate(rows):
            right = union(places_of(alignment, pose, 0))
            np.testing.assert_allclose(union(places), right, atol=1e-6, err_msg=f"{seed} {pose}")
    return True


@pytest.mark.parametrize("part", [0, *(pytest.param(part, marks=pytest.mark.sweep) for part in range(1, 5))])
def test_places_are_those_of_the_whole(part):
    followed = sum(agrees(seed) for seed in range(part, 600, 5))
    assert 40 < followed < 110
