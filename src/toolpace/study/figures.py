"""Figures 4 to 10 of the paper, from the simulated motions before and after the deflection."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from toolpace.common.arrays import Floats, Ints
from toolpace.deflection.detour import DetourRun
from toolpace.deflection.feed import tip_velocity
from toolpace.motion.laws import QuinticLaw
from toolpace.motion.trajectory import Trajectory
from toolpace.study.drawings import (
    GIVEN,
    INK,
    JOINT_COLOURS,
    MARK,
    WAY_COLOURS,
    WAY_NAMES,
    Curve,
    Figure,
    Panel,
    in_space,
    joined,
)
from toolpace.study.simulation import DEFLECTION, FEED, Study
from toolpace.study.tables import reversal

TIMES, MOTOR_TIMES = 1500, 1200
"""At how many times a stage is drawn: of the motors, which are more curves, at fewer."""
SHOWN = (-0.15, 0.6)
"""Time about the deflection that figures 9 and 10 show at first [s]: the way back and the next intervals."""
KINDS = (("position", "q"), ("velocity", "qd"), ("acceleration", "qdd"), ("jerk", "qddd"))
"""Each with the attribute of a motion that holds it."""
UNITS = {"linear": ("mm", "m/s", "m/s²", "m/s³"), "rotary": ("deg", "rad/s", "rad/s²", "rad/s³")}
"""Of the four kinds; positions are read more easily in mm and degrees."""


@dataclass(frozen=True)
class Stage:
    """A part of a trajectory, from one of its times to another, and what to add to them for the clock of the whole."""

    trajectory: Trajectory
    begin: float
    end: float
    shift: float

    def times(self, count: int, shown: tuple[float, float] | None = None) -> Floats:
        """(n,) times of the trajectory, evenly spread over the part of the stage that is shown on the whole's clock."""
        low, high = shown or (-np.inf, np.inf)
        begin, end = max(self.begin, low - self.shift), min(self.end, high - self.shift)
        return np.linspace(begin, end, count) if end > begin else np.empty(0)


def undisturbed(study: Study) -> dict[str, list[Stage]]:
    """The plans without deflection, from their start."""
    return {name: [Stage(before, 0.0, before.duration, 0.0)] for name, (before, _) in study.pairs().items()}


def disturbed(study: Study) -> dict[str, list[Stage]]:
    """The ways back, each with what was driven before it; the clock begins at the deflection.

    Behind the way back to the letter the known motion goes on, from the next reference point.
    """
    pairs = study.pairs()
    planned = pairs["genetic"][0]
    way = study.literal["acceleration"].trajectory
    before = {name: Stage(pairs[name][0], 0.0, instant, -instant) for name, instant in study.instant.items()}
    onwards = Stage(planned, study.next_point, planned.duration, way.duration - study.next_point)
    out = {"literal": [before["genetic"], Stage(way, 0.0, way.duration, 0.0), onwards]}
    return out | {name: [before[name], Stage(after, 0.0, after.duration, 0.0)] for name, (_, after) in pairs.items()}


def all_figures(study: Study) -> tuple[Figure, ...]:
    """Figures 4 to 10."""
    before, ways = undisturbed(study), disturbed(study)
    return (
        reference_curve(study),
        system_curve(study),
        feeds(study, 6, before, "without deflection"),
        motors(study, 7, before, "without deflection", caption="Linear and rotary axes on scales of their own."),
        deflected_curves(study),
        feeds(study, 9, ways, "with deflection", SHOWN),
        motors(study, 10, ways, "with deflection", shown=SHOWN, caption=reversal(study)),
    )


def reference_curve(study: Study) -> Figure:
    """Figure 4, with the tool axis that was chosen, drawn as whiskers."""
    run = study.path.runs[0]
    s = np.linspace(run.s0, run.s1, 400)
    curve = run.evaluate(s).tip[0]
    points = run.evaluate(study.points)
    assert points.rotary is not None
    axes = study.machine.axis_at(points.rotary[0])
    whiskers = [
        in_space("tool axis" if k == 0 else "", np.stack([p, p + 0.02 * o]), GIVEN)
        for k, (p, o) in enumerate(zip(points.tip[0], axes))
    ]
    space = Panel(
        "", "x [mm]", "y [mm]",
        (
            *whiskers,
            in_space("reference curve", curve, INK),
            in_space("reference points", points.tip[0], MARK, "marks"),
        ), "z [mm]",
    )  # fmt: skip
    angles = run.evaluate(s).rotary
    assert angles is not None
    turning = Panel(
        "rotary axes", "path [mm]", "angle [deg]",
        tuple(
            Curve(study.machine.joints[j], 1e3 * s, np.degrees(angles[0, :, i]), JOINT_COLOURS[study.machine.joints[j]])
            for i, j in enumerate(study.machine.rotary)
        ),
    )  # fmt: skip
    return Figure(
        4, "Reference curve in the workpiece frame", ((space, turning),),
        "Quarter circle of 0.1 m about the origin in the plane x = y, 31 intervals. The tool axis is our reading.",
    )  # fmt: skip


def system_curve(study: Study) -> Figure:
    """Figure 5: the tip by forward kinematics from the planned motors, against the arc's formula."""
    trajectory = study.genetic[1]
    t = np.linspace(0.0, trajectory.duration, TIMES)
    tip = trajectory.tip(t)[0]
    angle = trajectory.parameter(t) / 0.1
    flat = np.sin(angle) / np.sqrt(2.0)
    arc = 0.1 * np.stack([flat, flat, np.cos(angle)], axis=1)
    space = Panel(
        "", "x [mm]", "y [mm]",
        (in_space("from the motors", tip, WAY_COLOURS["genetic"]), in_space("reference", arc[::75], MARK, "marks")),
        "z [mm]",
    )  # fmt: skip
    off = Panel(
        "distance between both", "time [s]", "distance [1e-15 m]",
        (Curve("distance", t, 1e15 * np.linalg.norm(tip - arc, axis=1), WAY_COLOURS["genetic"]),),
    )  # fmt: skip
    return Figure(
        5, "Tool-workpiece system curve from the motors", ((space, off),),
        "Eq. (1) to (6) with the errata applied. What is left is the error of the quintic intervals.",
    )  # fmt: skip


def feeds(
    study: Study, number: int, ways: Mapping[str, list[Stage]], title: str, shown: tuple[float, float] | None = None
) -> Figure:
    """Figures 6 and 9: feed rate and du/dt, u running from 0 to 1 in each interval."""
    feed, rate = [], []
    for name, stages in ways.items():
        time, speed, pace = [], [], []
        for stage in stages:
            t = stage.times(TIMES)
            motion, state = stage.trajectory.at(t), stage.trajectory.laws[0].at(t)
            time.append(t + stage.shift)
            speed.append(1e3 * np.linalg.norm(tip_velocity(study.machine, motion.q, motion.qd), axis=1))
            pace.append(state[1] / lengths(study, stage.trajectory, state[0]))
        feed.append(Curve(WAY_NAMES[name], joined(time), joined(speed), WAY_COLOURS[name]))
        rate.append(Curve(WAY_NAMES[name], joined(time), joined(pace), WAY_COLOURS[name]))
    clock = "time [s]" if shown is None else "time since the deflection [s]"
    return Figure(
        number, f"Feed rate and du/dt {title}",
        ((Panel("feed rate", clock, "feed rate [mm/s]", tuple(feed), limit=1e3 * FEED, shown=shown),),
         (Panel("du/dt", clock, "du/dt [1/s]", tuple(rate), shown=shown),)),
        "" if shown is None else "The lines break where the tool is found deflected.",
    )  # fmt: skip


def lengths(study: Study, trajectory: Trajectory, s: Floats) -> Floats:
    """(n,) length in s of the interval in which s lies: 31 equal ones, the detour, and what it leaves of one."""
    run, law = trajectory.axis_path.runs[0], trajectory.laws[0]
    points = law.s if isinstance(law, QuinticLaw) else study.points
    if isinstance(run, DetourRun):
        points = np.concatenate([[run.s0, run.join], points[points > run.join + 1e-9]])
    k = np.clip(np.searchsorted(points, s, side="right") - 1, 0, len(points) - 2)
    out: Floats = np.diff(points)[k]
    return out


def deflected_curves(study: Study) -> Figure:
    """Figure 8: the way back in space, and seen in two planes."""
    run = study.path.runs[0]
    arc = run.evaluate(np.linspace(run.s0, run.s1, 2000)).tip[0]
    all_ways = study.ways()
    drawn = {"literal": all_ways["literal_acceleration"]} | {name: all_ways[name] for name in study.with_deflection}
    ways = {name: way.tip(np.linspace(0.0, duration, 600))[0] for name, (way, duration) in drawn.items()}
    marks = [
        ("deflection", np.array(DEFLECTION), INK),
        ("projection, 20th interval", study.interval.tip, MARK),
        ("projection, whole path", study.whole.tip, "#0f8a6a"),
    ]

    def curves(first: int, second: int | None) -> tuple[Curve, ...]:
        near = arc if second is None else arc[np.linalg.norm(arc - DEFLECTION, axis=1) < 0.008]
        named = [("reference", near, GIVEN, "line")]
        named += [(WAY_NAMES[name], way, WAY_COLOURS[name], "line") for name, way in ways.items()]
        named += [(name, point[None], colour, "marks") for name, point, colour in marks]
        if second is None:
            return tuple(in_space(*entry) for entry in named)
        return tuple(
            Curve(name, 1e3 * p[:, first], 1e3 * p[:, second], colour, None, style) for name, p, colour, style in named
        )

    space = Panel("", "x [mm]", "y [mm]", curves(0, None), "z [mm]")
    return Figure(
        8, "System curves without and with deflection",
        ((space, Panel("seen along y", "x [mm]", "z [mm]", curves(0, 2), equal=True),
          Panel("seen along z", "x [mm]", "y [mm]", curves(0, 1), equal=True)),),
        "To the letter and genetic go by way of the projection on the 20th interval, as printed; optimal rejoins where"
        " it costs least.",
    )  # fmt: skip


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
        t = stage.times(MOTOR_TIMES, shown)
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
