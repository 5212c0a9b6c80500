"""Five-axis demo programs: an impeller, and a blade of any length.

Both are G-code under tool-centre-point control (G43.4) for a machine with a C table and a tilting A or B axis, in mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats

if TYPE_CHECKING:
    from toolpace.machine.machine import Machine

ToolCurve = Callable[[Floats], tuple[Floats, Floats]]
"""Parameter (n,) to tip (n, 3) [m] and tool axis (n, 3), not necessarily of unit length."""

MACHINE = "xyzac-trunnion"
"""Built-in machine of the demo."""
FEED = 2.5 / 60.0
"""Feed of both programs [m/s]."""
BLADES = 7
TOOL_RADIUS = 2e-3
"""[m]"""
HALF_THICKNESS = 0.8e-3
"""Of a blade [m]."""
RETRACT = 30e-3
"""How far the tool leaves a blade along its own axis [m]."""
CLEARANCE = 75e-3
"""Height above the part at which it goes from blade to blade [m]."""


def impeller_program(machine: Machine | None = None, blocks_per_blade: int = 400) -> str:
    """An impeller of seven blades, each milled by the tool's flank: down one side, round its end, up the other."""
    machine = machine or _machine()
    lines = _head("impeller, seven blades, flank milling with a ball-end tool of 4 mm", machine)
    for blade in range(BLADES):
        tip, axis = blade_flank(blocks_per_blade, 2.0 * math.pi * blade / BLADES)
        lines.append(f"(blade {blade + 1})")
        ends = [tip[0] + RETRACT * axis[0], tip[-1] + RETRACT * axis[-1]]
        above = [np.array([*end[:2], CLEARANCE]) for end in ends]
        points = np.vstack([above[0], ends[0], tip, ends[1], above[1]])
        axes = np.vstack([axis[0], axis[0], axis, axis[-1], axis[-1]])
        lines += _blocks(machine, points, axes, rapids=(2, 2))
    return "\n".join([*lines, "G49", "M5", "M30", "%", ""])


def blade_flank(count: int, turn: float = 0.0) -> tuple[Floats, Floats]:
    """Tips (count, 3) [m] and unit tool axes (count, 3) round one blade, turned about z by `turn` [rad].

    The blade is ruled from a hub to a shroud curve, both quarter ellipses that wrap about z; the tool lies along the
    rulings at the distance of its radius.
    """
    straight, round_ = 0.46, 0.08
    w = np.linspace(0.0, 1.0, count)
    along_round = np.clip((w - straight) / round_, 0.0, 1.0)
    # Past the rim and back, as fast at both ends as along the flanks; the tool goes round softly meanwhile.
    beyond = round_ / (math.pi * straight) * np.sin(math.pi * along_round)
    u = np.minimum(np.clip(np.minimum(w, 1.0 - w) / straight, 0.0, 1.0) + beyond, 1.0 + beyond)
    half_turn = math.pi * along_round - 0.5 * np.sin(2.0 * math.pi * along_round)
    hub, along = _hub(u)
    ruling = _normalised(_shroud(u) - hub)
    along = _normalised(along)
    side = _normalised(np.cross(ruling, along))
    forward = np.cross(side, ruling)
    distance = TOOL_RADIUS + HALF_THICKNESS
    tip = hub + distance * (np.cos(half_turn)[:, None] * side + np.sin(half_turn)[:, None] * forward)
    cosine, sine = math.cos(turn), math.sin(turn)
    about_z = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return tip @ about_z.T, ruling @ about_z.T


def _hub(u: Floats) -> tuple[Floats, Floats]:
    """Curve of the hub (n, 3) [m] from the eye (u = 0) to the rim (u = 1), and its tangent."""
    return _meridian(u, 10e-3, 36e-3, 36e-3, 0.0), _derivative(lambda v: _meridian(v, 10e-3, 36e-3, 36e-3, 0.0), u)


def _shroud(u: Floats) -> Floats:
    return _meridian(u, 22e-3, 40e-3, 38e-3, 0.15, base=9e-3)


def _meridian(u: Floats, eye: float, rim: float, height: float, lean: float, base: float = 0.0) -> Floats:
    """Quarter ellipse from radius `eye` at the top to `rim` at the bottom, wrapped about z by 50 degrees and `lean`."""
    angle = 0.5 * math.pi * (0.06 + 0.9 * u)
    radius = rim - (rim - eye) * np.cos(angle)
    z = base + height * (1.0 - np.sin(angle))
    wrap = math.radians(50.0) * u * (1.5 - 0.5 * u) + lean
    return np.column_stack([radius * np.cos(wrap), radius * np.sin(wrap), z])


def _derivative(f: Callable[[Floats], Floats], u: Floats, step: float = 1e-5) -> Floats:
    return (f(u + step) - f(u - step)) / (2.0 * step)


def blade_spiral(turns: float) -> ToolCurve:
    """A twisted turbine blade finished in one spiral of `turns` round it, as a curve over the angle [rad]."""
    height, long, short = 60e-3, 22e-3, 9e-3

    def curve(angle: Floats) -> tuple[Floats, Floats]:
        share = angle / (2.0 * math.pi * turns)
        twist = math.radians(35.0) * share
        scale = 1.0 - 0.25 * share
        section = np.column_stack([scale * long * np.cos(angle), scale * short * np.sin(angle)])
        # The tool leans to a rounder section than it cuts: else it would whirl about the edges.
        outward = np.column_stack([np.cos(angle) * 0.75, np.sin(angle)])
        tip = np.column_stack([_turned_in_plane(section, twist), height * share])
        axis = np.column_stack([_turned_in_plane(outward, twist), np.full(len(angle), 1.1)])
        return tip, axis

    return curve


def _turned_in_plane(plane: Floats, angle: Floats) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * plane[:, 0] - s * plane[:, 1], s * plane[:, 0] + c * plane[:, 1]])


def spiral_program(blocks: int, machine: Machine | None = None, spacing: float = 0.5e-3, decimals: int = 4) -> str:
    """One pass of `blocks` five-axis blocks of about `spacing` [m]: the spiral round a blade, rounded to `decimals`."""
    machine = machine or _machine()
    lines = _head(f"blade, one spiral of {blocks} blocks", machine)
    tip, axis = sampled_spiral(blocks + 1, spacing)
    lines += _blocks(machine, tip, axis, rapids=(1, 0), decimals=decimals)
    return "\n".join([*lines, "G49", "M5", "M30", "%", ""])


def sampled_spiral(count: int, spacing: float) -> tuple[Floats, Floats]:
    """Tips (count, 3) [m] and unit axes of the spiral, `spacing` [m] apart along it."""
    shortest_turn = 88e-3
    """A bit less than the mean length of a turn [m]."""
    turns = max(20.0, spacing * count / shortest_turn)
    curve = blade_spiral(turns)
    # As much of the spiral as is needed, twelve points or more to a block: chords of them show no error of note.
    share = min(1.0, 1.5 * spacing * count / (shortest_turn * turns))
    angle = np.linspace(0.0, 2.0 * math.pi * turns * share, max(12 * count, 1000))
    tip, _ = curve(angle)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tip, axis=0), axis=1))])
    tip, axis = curve(np.interp(spacing * np.arange(count), length, angle))
    return tip, _normalised(axis)


def _machine() -> Machine:
    from toolpace.machine.machine import Machine

    return Machine.load(MACHINE)


def _normalised(v: Floats) -> Floats:
    unit: Floats = v / np.linalg.norm(v, axis=1, keepdims=True)
    return unit


def _head(title: str, machine: Machine) -> list[str]:
    return ["%", f"({title}; for {machine.name})", "G21 G90 G94 G17 G40", "T1 M6", "S18000 M3", "G43.4 H1"]


def _blocks(machine: Machine, tip: Floats, axis: Floats, rapids: tuple[int, int], decimals: int = 4) -> list[str]:
    """The points as blocks, the first and last so many of them as rapids; rotary words in degrees, unwound."""
    from toolpace.programs.toolpath import ToolPath

    n = len(tip)
    free, nothing = np.full(n, np.inf), np.zeros(n)
    ends = np.isin(np.arange(n), (0, n - 1))
    toolpath = ToolPath(tip, axis, free, nothing, np.arange(1, n + 1), ends, nothing.copy())
    order = sorted((0, 1), key=lambda k: machine.joints[machine.rotary[k]])
    angles = np.degrees(machine.choose_rotary(toolpath))[:, order]
    names = [machine.joints[joint] for joint in machine.rotary[order]]
    form = "G{} X{:.{d}f} Y{:.{d}f} Z{:.{d}f} " + " ".join(f"{name}{{:.{{d}}f}}" for name in names)
    rows = np.column_stack([tip * 1e3, angles]).tolist()
    lines = []
    for k, row in enumerate(rows):
        rapid = k < rapids[0] or k >= n - rapids[1]
        lines.append(form.format(0 if rapid else 1, *row, d=decimals))
    lines[rapids[0]] += f" F{FEED * 60e3:g}"
    return lines
