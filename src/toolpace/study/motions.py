"""Figures 7 and 10: position, velocity, acceleration and jerk of the motors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.study.panels import JOINT_COLOURS, WAY_NAMES, Curve, Figure, Panel, joined
from toolpace.study.simulation import Study
from toolpace.study.stages import Stage

TIMES = 1200
"""At how many times a stage is drawn."""
KINDS = (("position", "q"), ("velocity", "qd"), ("acceleration", "qdd"), ("jerk", "qddd"))
"""Each with the attribute of a motion that holds it."""
UNITS = {"linear": ("mm", "m/s", "m/s²", "m/s³"), "rotary": ("deg", "rad/s", "rad/s²", "rad/s³")}
"""Of the four kinds; positions are read more easily in mm and degrees."""


def motors(
    study: Study,
    number: int,
    ways: Mapping[str, list[Stage]],
    title: str,
    *,
    shown: tuple[float, float] | None = None,
    caption: str = "",
) -> Figure:
    """A column for each way, a row for each kind and each sort of axes; `shown` is the part of the clock drawn.

    Positions count from where the joints stand as the clock begins.
    """
    rows = []
    rotary = np.array(study.machine.rotary, dtype=np.int64)
    linear = np.setdiff1d(np.arange(len(study.machine.joints)), rotary)
    sorts = {sort: by_name(study, joints) for sort, joints in (("linear", linear), ("rotary", rotary))}
    for order, (kind, _) in enumerate(KINDS):
        for sort, joints in sorts.items():
            unit = UNITS[sort][order]
            rows.append(
                tuple(
                    motor_panel(study, stages, kind, sort, joints, unit, name, shown) for name, stages in ways.items()
                )
            )
    clock = "time [s]" if shown is None else "time since the deflection [s]"
    rows[-1] = tuple(replace(panel, x_label=clock) for panel in rows[-1])
    return Figure(number, f"Position, velocity, acceleration and jerk of the motors {title}", tuple(rows), caption)


def motor_panel(
    study: Study, stages: list[Stage], kind: str, sort: str, joints: Ints, unit: str, name: str,
    shown: tuple[float, float] | None,
) -> Panel:  # fmt: skip
    """One kind of one sort of axes on one way."""
    attribute = dict(KINDS)[kind]
    time, values = [], []
    for stage in stages:
        t = stage.times(TIMES, shown)
        if len(t):
            time.append(t + stage.shift)
            values.append(getattr(stage.trajectory.at(t), attribute)[:, joints])
    limit, note = None, ""
    if kind == "position":
        values = [from_the_start(each, stages, joints) for each in values]
        values = [np.degrees(each) if sort == "rotary" else 1e3 * each for each in values]
    else:
        limit = float(getattr(study.machine.limits, kind)[joints].min())
        note = f"limit ±{limit:g}, peak {max(np.abs(each).max() for each in values):.3g}"
    names = [study.machine.joints[j] for j in joints]
    curves = tuple(
        Curve(joint, joined(time), joined([each[:, i] for each in values]), JOINT_COLOURS[joint])
        for i, joint in enumerate(names)
    )
    title = f"{kind} of {' '.join(names)}, {WAY_NAMES[name]}"
    return Panel(title, "", f"{kind} [{unit}]", curves, limit=limit, note=note)


def by_name(study: Study, joints: Ints) -> Ints:
    """The joints in the order of their names."""
    return np.array(sorted(joints, key=lambda j: study.machine.joints[j]), dtype=np.int64)


def from_the_start(values: Floats, stages: list[Stage], joints: Ints) -> Floats:
    """(n, k) positions less those that the first stage ends with, where others follow: what the deflection found."""
    if len(stages) == 1:
        return values
    start: Floats = stages[0].trajectory.at(np.array([stages[0].end])).q[0, joints]
    return values - start
