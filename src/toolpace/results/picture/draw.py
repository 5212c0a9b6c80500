"""A planned motion at a moment as a picture: stock, tool, path by speed, fixtures, and the machine on request."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Floats, Ints
from toolpace.common.errors import UsageError
from toolpace.machine.machine import Machine
from toolpace.motion.trajectory import Trajectory
from toolpace.motion.trajectory_file import TRAJECTORY
from toolpace.programs.reading import Source, read_source
from toolpace.programs.reading.coordinates.setup import SetUp
from toolpace.programs.toolpath import ToolPath
from toolpace.results.picture.rasteriser import Canvas
from toolpace.results.picture.solids import bodies_at, machine_bodies, origin_of, revolved
from toolpace.results.report.machine_view import machine_view
from toolpace.results.report.passages import RAPID, passages
from toolpace.results.workpiece.view import WorkpieceView, outline, view_of_stock
from toolpace.results.write import read_again, read_plan, refuse_without_set_points

VIEWS = ("iso", "top", "front", "right", "machine")
"""From where a picture is taken; "machine" shows its bodies too, as iso does the part."""
AROUND, ABOVE = -0.95, 0.5
"""Direction of iso, from X towards Y and up [rad]: that of the report."""
PATH_POINTS = 30_000
"""Of the path, evenly over time."""
GROUND = (0.102, 0.133, 0.18)
RAW, MACHINED = np.array([0.42, 0.47, 0.54]), np.array([0.80, 0.84, 0.89])
PART, FIXTURE = (0.21, 0.75, 0.54), (0.54, 0.42, 0.31)
TOOL = ((0.88, 0.67, 0.27), (0.73, 0.76, 0.81), (0.47, 0.52, 0.60))
"""Of the cutting part, the shank and the holder."""
RAMP = np.array([(72, 112, 214), (58, 138, 206), (72, 164, 186), (124, 188, 148), (196, 210, 96), (255, 232, 72)]) / 255
"""Of speeds, from slow to fast: that of the report."""
RAPIDS, AHEAD = np.array([0.40, 0.45, 0.52]), np.array([0.32, 0.38, 0.46])
"""Of rapids, and of what is passed later."""
SUN = np.array([0.35, 0.5, 0.8]) / np.linalg.norm([0.35, 0.5, 0.8])
"""Direction of the light, to the right, up, and towards who looks."""
UNKNOWN_HOLDER = 1.6
"""Radius of what stands for a holder, over that of the tool: that of the report."""
MARGIN = 1.12
"""Of what is shown, around what is cut."""


@dataclass(frozen=True)
class Camera:
    """An orthographic view."""

    axes: Floats
    """(3, 3) rows: to the right, up, and towards who looks."""
    centre: Floats
    """(3,) [m]"""
    scale: float
    """Pixels per metre."""
    size: tuple[int, int]

    def project(self, points: Floats) -> Floats:
        """Places (..., 3) [m] as x and y in pixels, and the depth [m]."""
        seen = (points - self.centre) @ self.axes.T
        x = 0.5 * self.size[0] + self.scale * seen[..., 0]
        y = 0.5 * self.size[1] - self.scale * seen[..., 1]
        return np.stack([x, y, -seen[..., 2]], axis=-1)


def direction_axes(view: str) -> Floats:
    """(3, 3) rows of a camera: to the right, up, towards who looks. Raises UsageError for a view that is none."""
    if view not in VIEWS:
        raise UsageError(f"--view {view[:40]}: give one of {', '.join(VIEWS)}")
    c, s = np.cos(ABOVE), np.sin(ABOVE)
    towards = {
        "top": [0.0, 0.0, 1.0], "front": [0.0, -1.0, 0.0], "right": [1.0, 0.0, 0.0],
    }.get(view, [c * np.cos(AROUND), c * np.sin(AROUND), s])  # fmt: skip
    up = np.array([0.0, 1.0, 0.0]) if view == "top" else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), np.array(towards)])


@dataclass(frozen=True)
class ShownPlan:
    """A planned motion and what there is to be seen of it."""

    trajectory: Trajectory
    toolpath: ToolPath
    workpiece: WorkpieceView
    """Without tracks."""

    @classmethod
    def load(cls, folder: str | Path) -> ShownPlan:
        """That of a folder that `toolpace plan` wrote. Raises UsageError where it is none, or tells no motion."""
        place = Path(folder)
        record = read_plan(place)
        refuse_without_set_points(place, "drawn")
        trajectory = Trajectory.load(place, exact=(place / TRAJECTORY).is_file())
        options = read_again(place, record.reading)
        source = Source.load(place / record.program_file)
        toolpath = read_source(source, cls._machine(trajectory), record.dialect, options, feed=record.feed)
        return cls.of(trajectory, toolpath, options.setup)

    @classmethod
    def of(cls, trajectory: Trajectory, toolpath: ToolPath, setup: SetUp) -> ShownPlan:
        """A motion, with the stock, the tools and the fixtures of a set-up sheet."""
        return cls(trajectory, toolpath, view_of_stock(trajectory, toolpath, setup))

    @staticmethod
    def _machine(trajectory: Trajectory) -> Machine:
        machine = trajectory.axis_path.machine
        if machine is None:
            raise UsageError("picture: the motion has no machine, and so no tool; plan a program on one")
        return machine

    @property
    def machine(self) -> Machine:
        """On which it moves."""
        return self._machine(self.trajectory)

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.trajectory.duration)

    def tool_at(self, t: Floats) -> tuple[Floats, Floats]:
        """Tip (n, 3) [m] and tool axis (n, 3) at times (n,) [s], in the frame of the part."""
        return self.machine.forward(self.trajectory.at(t).q, self.length_at(t))

    def length_at(self, t: Floats) -> Floats:
        """(n,) of the tool, from its tip to the nose of the spindle, at times (n,) [m]."""
        lengths = np.asarray(self.trajectory.axis_path.tool_lengths, dtype=np.float64)
        found: Floats = np.where(np.isnan(lengths), self.machine.tool_length, lengths)[self.trajectory.run_at(t)]
        return found

    @cached_property
    def path(self) -> tuple[Floats, Floats, Floats, Ints, Ints]:
        """Times (n,), tips (n, 3), speeds (n,) on the way to each, whether that is a rapid (n,), and the operation."""
        t = np.linspace(0.0, self.duration, PATH_POINTS)
        tip = self.tool_at(t)[0]
        step = t[1] - t[0]
        speed = np.linalg.norm(np.diff(tip, axis=0, prepend=tip[:1]), axis=1) / step
        passed = passages(self.trajectory, self.trajectory.sample(max(1e-3, self.duration / 1e5)), self.toolpath)
        at = np.clip(np.searchsorted(passed.t, t - 0.5 * step, side="right") - 1, 0, len(passed.t) - 1)
        return t, tip, speed, passed.kind[at] == RAPID, passed.operation[at]

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Corners (3,) of the box about what is cut, without the hundredth that lies farthest out."""
        _, tip, _, rapid, _ = self.path
        cut = tip[~rapid] if (~rapid).any() else tip
        low, high = np.quantile(cut, 0.01, axis=0), np.quantile(cut, 0.99, axis=0)
        if self.workpiece.stages is not None:
            stages = self.workpiece.stages
            low = np.minimum(low, stages.origin)
            high = np.maximum(high, stages.origin + stages.step * (stages.points - 1))
        return low, high

    @cached_property
    def usual_speed(self) -> float:
        """What nearly all that is passed at feed stays below [m/s]."""
        _, _, speed, rapid, _ = self.path
        return max(float(np.quantile(speed[~rapid] if (~rapid).any() else speed, 0.97)), 1e-9)


def picture(
    shown: ShownPlan, t: float, view: str = "iso", size: tuple[int, int] = (1200, 900)
) -> npt.NDArray[np.uint8]:
    """Pixels (height, width, 3) of a motion at a time [s]; the path up to then is coloured by speed."""
    axes, (low, high) = direction_axes(view), shown.bounds
    place, centre, room = np.eye(4), 0.5 * (low + high), 1.0
    machine = machine_view(shown.machine)
    q = shown.trajectory.at(np.array([t])).q[0]
    if view == "machine":
        on = bodies_at(machine["workpiece"], q)
        place = (on[-1] if on else np.eye(4)) @ origin_of(machine)
        extent = float(np.linalg.norm(high - low))
        centre, room = placed(centre, place) + np.array([0.0, 0.0, 0.35 * extent]), 2.4
    corners = np.array([[(low, high)[k >> d & 1][d] for d in range(3)] for k in range(8)]) @ axes[:2].T
    extent = np.ptp(corners, axis=0) * MARGIN * room
    camera = Camera(axes, centre, float((np.array(size) / extent).min()), size)
    canvas = Canvas(*size, GROUND)
    drawn = _workpiece(shown.workpiece, shown.workpiece.stages.stage_at(t) if shown.workpiece.stages else 0)
    drawn += _tool(shown, t)
    for triangles, colours in drawn:
        _shade(canvas, camera, placed(triangles, place), colours)
    if view == "machine":
        for body in machine_bodies(machine, low, high):
            by = bodies_at(machine[body.chain], q)
            _shade(canvas, camera, placed(body.triangles, by[body.joint] if by else np.eye(4)), body.colour)
    canvas.outlined(0.02 * float(np.linalg.norm(high - low)))
    _path(canvas, camera, shown, t, place)
    return canvas.pixels()


def placed(points: Floats, place: Floats) -> Floats:
    """Points (..., 3) moved by a placement (4, 4)."""
    found: Floats = points @ place[:3, :3].T + place[:3, 3]
    return found


def _workpiece(view: WorkpieceView, stage: int) -> list[tuple[Floats, npt.ArrayLike]]:
    """Triangles with their colours: the stock at a stage, or the finished part without one, and fixtures."""
    found: list[tuple[Floats, npt.ArrayLike]] = [(triangles, FIXTURE) for _, triangles in view.fixtures]
    if view.stages is not None:
        triangles, cut = view.stages.surface(stage)
        found.append((triangles, np.where(cut[:, None], MACHINED, RAW)))
    elif view.finished_part is not None:
        found.append((view.finished_part, PART))
    return found


def _tool(shown: ShownPlan, t: float) -> list[tuple[Floats, npt.ArrayLike]]:
    """The tool where it is at a time; of one whose shape is not known a thin cylinder."""
    (tip,), (axis,) = shown.tool_at(np.array([t]))
    times, _, _, _, operation = shown.path
    number = int(operation[min(int(np.searchsorted(times, t)), len(times) - 1)])
    profile = shown.workpiece.tools[number] if number < len(shown.workpiece.tools) else None
    if profile is None:
        low, high = shown.bounds
        wide = 0.02 * float(np.linalg.norm(high - low))
        return [(revolved(np.array([[0.0, 0.5 * wide], [12.0 * wide, 0.5 * wide]]), tip, axis), TOOL[0])]
    parts = [(profile.cutting, 0), *((each, 1) for each in profile.shank), *((each, 2) for each in profile.holder)]
    outlines = [(outline(solid), part) for solid, part in parts]
    top, radius = outlines[-1][0][-1]
    reach = shown.length_at(np.array([t]))[0]
    if reach > top:
        # what holds the tool, where the sheet does not tell it
        radius *= 1.0 if profile.holder else UNKNOWN_HOLDER
        outlines.append((np.array([[top, radius], [reach, radius]]), 2))
    return [(revolved(each, tip, axis), TOOL[part]) for each, part in outlines]


def _shade(canvas: Canvas, camera: Camera, triangles: Floats, colours: npt.ArrayLike) -> None:
    """Draw triangles (n, 3, 3) [m] in the light; colours are (n, 3), or one (3,)."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    facing = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0) @ camera.axes.T
    light = 0.42 + 0.5 * np.maximum(facing @ SUN, 0.0) + 0.16 * np.maximum(facing[:, 2], 0.0)
    shaded = np.clip(np.broadcast_to(np.asarray(colours), (len(triangles), 3)) * light[:, None], 0.0, 1.0)
    canvas.triangles(camera.project(triangles), shaded)


def _path(canvas: Canvas, camera: Camera, shown: ShownPlan, t: float, place: Floats) -> None:
    """Draw the path, its frame at a place (4, 4): by speed up to a time [s]."""
    times, tip, speed, rapid, _ = shown.path
    share = np.clip(speed[1:] / shown.usual_speed, 0.0, 1.0)
    colours = np.stack([np.interp(share, np.linspace(0.0, 1.0, len(RAMP)), RAMP[:, c]) for c in range(3)], axis=1)
    colours[rapid[1:]] = RAPIDS
    later = times[1:] > t
    colours[later] = AHEAD
    low, high = shown.bounds
    in_front = 0.004 * float(np.linalg.norm(high - low))
    ends = camera.project(placed(np.stack([tip[:-1], tip[1:]], axis=1), place))
    thin = rapid[1:] | later
    canvas.lines(ends[thin], colours[thin], 1.0, in_front)
    canvas.lines(ends[~thin], colours[~thin], 2.0, in_front)
