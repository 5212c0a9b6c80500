"""Figures 4 to 10 of the paper as plain data, for page and PNG alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from toolpace.arrays import Floats
from toolpace.deflect.detour import DetourRun
from toolpace.deflect.feed import tip_velocity
from toolpace.study.simulation import DEFLECTION, FEED, Study, detour_run
from toolpace.trajectory import Trajectory

TIMES = 1500
"""At how many times a trajectory is drawn."""
COLOURS = {"X": "#2563c9", "Y": "#0f8a6a", "Z": "#7a4fd0", "A": "#d9622b", "B": "#c2255c"}
"""By joint."""
GENETIC, OPTIMAL, REFERENCE, MARK = "#d9622b", "#2563c9", "#9aa5b4", "#c2255c"
"""Colours of both planners, of what is given, and of marks."""
NAMES = {"genetic": "genetic (the paper's)", "optimal": "optimal"}
"""Of the planners, in legends."""
FAR = 3.0
"""Limits further out than this multiple of the data are named, not drawn."""


@dataclass(frozen=True)
class Curve:
    """One line, or marks, of a panel; z for a panel in space."""

    name: str
    x: Floats
    y: Floats
    colour: str
    z: Floats | None = None
    style: str = "line"
    """line, dash, or marks"""


@dataclass(frozen=True)
class Panel:
    """One pair or triple of axes."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    z_label: str = ""
    limit: float | None = None
    """Drawn as a line above (and below, if the curves go there); if it lies far outside it is only named."""
    note: str = ""
    equal: bool = False
    """Whether both axes have the same scale."""

    @property
    def in_space(self) -> bool:
        """Whether its curves have three coordinates."""
        return any(curve.z is not None for curve in self.curves)


@dataclass(frozen=True)
class Figure:
    """One figure of the paper, redrawn."""

    number: int
    title: str
    rows: tuple[tuple[Panel, ...], ...]
    caption: str = field(default="")


def all_figures(study: Study) -> tuple[Figure, ...]:
    """Figures 4 to 10."""
    without = {name: (a,) for name, (a, _) in study.pairs().items()}
    return (
        reference_curve(study),
        system_curve(study),
        feeds(study, 6, without, "without deflection"),
        motions(study, 7, without, "without deflection"),
        deflected_curves(study),
        feeds(study, 9, study.pairs(), "with deflection"),
        motions(study, 10, study.pairs(), "with deflection"),
    )


def in_space(name: str, points: Floats, colour: str, style: str = "line") -> Curve:
    """A curve of points (n, 3) [m], in mm."""
    x, y, z = 1e3 * np.atleast_2d(points).T
    return Curve(name, x, y, colour, z, style)


def reference_curve(study: Study) -> Figure:
    """Figure 4, with the tool axis that was chosen, drawn as whiskers."""
    run = study.path.runs[0]
    s = np.linspace(run.s0, run.s1, 400)
    curve = run.evaluate(s).tip[0]
    points = run.evaluate(study.points)
    assert points.rotary is not None
    axes = study.machine.axis_at(points.rotary[0])
    whiskers = [
        in_space("tool axis" if k == 0 else "", np.stack([p, p + 0.02 * o]), REFERENCE)
        for k, (p, o) in enumerate(zip(points.tip[0], axes))
    ]
    space = Panel(
        "", "x [mm]", "y [mm]",
        (
            *whiskers,
            in_space("reference curve", curve, OPTIMAL),
            in_space("reference points", points.tip[0], MARK, "marks"),
        ), "z [mm]",
    )  # fmt: skip
    angles = run.evaluate(s).rotary
    assert angles is not None
    turning = Panel(
        "rotary axes", "path [mm]", "angle [deg]",
        tuple(
            Curve(study.machine.joints[j], 1e3 * s, np.degrees(angles[0, :, i]), COLOURS[study.machine.joints[j]])
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
        (in_space("from the motors", tip, OPTIMAL), in_space("reference", arc[::75], MARK, "marks")), "z [mm]",
    )  # fmt: skip
    off = Panel(
        "distance between both", "time [s]", "distance [1e-15 m]",
        (Curve("distance", t, 1e15 * np.linalg.norm(tip - arc, axis=1), OPTIMAL),),
    )  # fmt: skip
    return Figure(
        5, "Tool-workpiece system curve from the motors", ((space, off),),
        "Eq. (1) to (6) with the errata applied. What is left is the error of the quintic intervals.",
    )  # fmt: skip


def timeline(parts: tuple[Trajectory, ...], instant: float) -> Iterable[tuple[Trajectory, Floats, float]]:
    """What to draw: each trajectory, its times, and what to add for the clock of the whole."""
    if len(parts) == 1:
        yield parts[0], np.linspace(0.0, parts[0].duration, TIMES), 0.0
        return
    yield parts[0], np.linspace(0.0, instant, TIMES), 0.0
    yield parts[1], np.linspace(0.0, parts[1].duration, TIMES), instant


def feeds(study: Study, number: int, parts: Mapping[str, tuple[Trajectory, ...]], title: str) -> Figure:
    """Figures 6 and 9: feed rate and du/dt, u running from 0 to 1 in each interval."""
    feed, rate = [], []
    for name, own in parts.items():
        colour = GENETIC if name == "genetic" else OPTIMAL
        time, speed, pace = [], [], []
        for trajectory, t, shift in timeline(own, study.instant[name]):
            motion = trajectory.at(t)
            state = trajectory.laws[0].at(t)
            time.append(t + shift)
            speed.append(1e3 * np.linalg.norm(tip_velocity(study.machine, motion.q, motion.qd), axis=1))
            pace.append(state[1] / lengths(study, trajectory, state[0]))
        feed.append(Curve(NAMES[name], joined(time), joined(speed), colour))
        rate.append(Curve(NAMES[name], joined(time), joined(pace), colour))
    return Figure(
        number, f"Feed rate and du/dt {title}",
        ((Panel("feed rate", "time [s]", "feed rate [mm/s]", tuple(feed), limit=1e3 * FEED),),
         (Panel("du/dt", "time [s]", "du/dt [1/s]", tuple(rate)),)),
        "" if number == 6 else "The lines break where the tool is found deflected.",
    )  # fmt: skip


def lengths(study: Study, trajectory: Trajectory, s: Floats) -> Floats:
    """(n,) length in s of the interval in which s lies: 31 equal ones, the detour, and what it leaves of one."""
    points = study.points
    run = trajectory.axis_path.runs[0]
    if isinstance(run, DetourRun):
        points = np.concatenate([[run.s0, run.join], points[points > run.join + 1e-9]])
    k = np.clip(np.searchsorted(points, s, side="right") - 1, 0, len(points) - 2)
    out: Floats = np.diff(points)[k]
    return out


def joined(parts: list[Floats]) -> Floats:
    """One after the other with a gap between."""
    out: Floats = np.concatenate([x for part in parts for x in ([np.nan], part)][1:])
    return out


def motions(study: Study, number: int, parts: Mapping[str, tuple[Trajectory, ...]], title: str) -> Figure:
    """Figures 7 and 10: velocity, acceleration and jerk of the motors; limits are the same number for both kinds."""
    rows = []
    for kind, attribute, unit in (
        ("velocity", "qd", "m/s, rad/s"),
        ("acceleration", "qdd", "m/s², rad/s²"),
        ("jerk", "qddd", "m/s³, rad/s³"),
    ):
        panels = []
        limit = float(getattr(study.machine.limits, kind)[0])
        for name, own in parts.items():
            time, values = [], []
            for trajectory, t, shift in timeline(own, study.instant[name]):
                time.append(t + shift)
                values.append(getattr(trajectory.at(t), attribute))
            peak = max(np.abs(v).max() for v in values)
            curves = tuple(
                Curve(joint, joined(time), joined([v[:, i] for v in values]), COLOURS[joint])
                for i, joint in enumerate(study.machine.joints)
            )
            note = f"limit ±{limit:g}, peak {peak:.3g}"
            panels.append(Panel(f"{kind}, {NAMES[name]}", "time [s]", unit, curves, limit=limit, note=note))
        rows.append(tuple(panels))
    return Figure(number, f"Velocity, acceleration and jerk of the motors {title}", tuple(rows))


def deflected_curves(study: Study) -> Figure:
    """Figure 8: the way back in space, and seen in two planes."""
    trajectories = study.with_deflection
    run = study.path.runs[0]
    arc = run.evaluate(np.linspace(run.s0, run.s1, 2000)).tip[0]
    ways = {}
    for name, trajectory in trajectories.items():
        ways[name] = trajectory.tip(np.linspace(0.0, detour_run(trajectory).detour.duration, 600))[0]
    marks = [
        ("deflection", np.array(DEFLECTION), "#17202e"),
        ("projection, 20th interval", study.interval.tip, MARK),
        ("projection, whole path", study.whole.tip, "#0f8a6a"),
    ]
    colours = {"genetic": GENETIC, "optimal": OPTIMAL}

    def curves(first: int, second: int | None) -> tuple[Curve, ...]:
        near = arc if second is None else arc[np.linalg.norm(arc - DEFLECTION, axis=1) < 0.008]
        named = [("reference", near, REFERENCE, "line")]
        named += [(NAMES[name], way, colours[name], "line") for name, way in ways.items()]
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
        "genetic goes by way of the projection on the 20th interval, as printed; optimal rejoins where it costs least.",
    )  # fmt: skip
