"""Presets, frames, planes, M128, LN and tools in random orders, against the arithmetic of the testbed."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.heidenhain_frames.held import EXPECTED, held
from testbed.heidenhain_frames.program import Writer
from testbed.heidenhain_frames.words import MACHINES
from testbed.heidenhain_frames.world import World


def faults(seeds):
    """What is wrong, by seed, and how many programs were held."""
    found = {seed: held(seed) for seed in seeds}
    unexpected = [
        f"{seed}: {each.refused}" for seed, each in found.items()
        if each.refused and not any(part in each.refused for part in EXPECTED)
    ]  # fmt: skip
    wrong = [f"{seed}: {each.wrong}" for seed, each in found.items() if each.wrong]
    off = [f"{seed}: {each}" for seed, each in found.items() if max(each.tip, each.axis, each.way) > 1e-6]
    return unexpected + wrong + off, sum(not each.refused for each in found.values())


def test_the_tip_is_where_the_control_brings_it():
    """Three programs a machine of twelve: no block ends a micrometre off, and no way of the tip bends."""
    wrong, read = faults(range(3 * len(MACHINES)))
    assert wrong == []
    assert read > 2 * len(MACHINES)


@pytest.mark.parametrize(
    "seeds",
    [
        pytest.param(range(100_000, 100_240), marks=pytest.mark.sweep, id="some"),
        pytest.param(range(100_240, 100_600), marks=pytest.mark.thorough, id="many"),
    ],
)
def test_the_tip_is_where_the_control_brings_it_in_many_programs(seeds):
    wrong, read = faults(seeds)
    assert wrong == []
    assert read > 0.66 * len(seeds)


@pytest.mark.parametrize("method", ["take_shift", "rotate", "tilt", "tip_mode", "tool", "retract", "vector_line"])
def test_a_method_that_is_left_out_is_seen(method, monkeypatch):
    """The programs try what they are for: where the truth leaves a word out, they disagree with the reader."""
    monkeypatch.setattr(World, method, lambda *_, **__: None)
    assert any(held(seed).wrong for seed in range(24))


def test_the_programs_have_all_words():
    said = set().union(*(Writer(seed).write().said for seed in range(60)))
    assert said >= {
        "take_preset", "take_shift", "mirror", "rotate", "scale", "scale_axes", "tilt", "tilt_axial", "untilt",
        "position", "tip_mode", "tool", "line", "spatial_line", "vector_line", "machine_line", "retract",
    }  # fmt: skip
    assert np.isfinite([step[0] for step in Writer(0).write().steps]).all()
