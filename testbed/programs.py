"""Programs: an S, a pass known from a paper, a contour with much room between its points, waves of any length."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.machine import Machine
from toolpace.programs.toolpath import ToolPath

TULSYAN = """
    -126.8941 -218.1150  0.0020  -0.0903 -0.0045 0.9959
    -128.4609 -216.2938  0.0106  -0.0876 -0.0086 0.9961
    -129.9710 -212.4296  0.0195  -0.0852 -0.0127 0.9963
    -131.4084 -208.5468  0.0334  -0.0832 -0.0169 0.9964
    -132.7896 -204.6471  0.0582  -0.0808 -0.0212 0.9965
    -134.1019 -200.6663  0.0992  -0.0795 -0.0255 0.9965
    -135.3063 -196.6949  0.1599  -0.0793 -0.0304 0.9964
    -136.4486 -192.7186  0.2432  -0.0789 -0.0353 0.9963
    -137.5210 -188.6998  0.3545  -0.0790 -0.0402 0.9961
    -138.5106 -184.6587  0.4980  -0.0799 -0.0453 0.9958
    -139.4174 -180.5996  0.6779  -0.0814 -0.0505 0.9954
    -142.1853 -164.2366  1.8069  -0.0968 -0.0725 0.9927
    -142.6594 -160.1177  2.1913  -0.1030 -0.0782 0.9916
    -143.0440 -156.0004  2.6151  -0.1102 -0.0840 0.9903
    -143.5522 -147.7734  3.5784  -0.1285 -0.0956 0.9871
    -143.6792 -143.6627  4.1199  -0.1394 -0.1011 0.9851
    -143.7220 -139.5544  4.7185  -0.1513 -0.1065 0.9827
    -143.6852 -135.4594  5.3892  -0.1643 -0.1118 0.9800
    -143.5705 -131.3751  6.1222  -0.1782 -0.1169 0.9770
    -143.3775 -127.3064  6.9027  -0.1930 -0.1217 0.9736
    -143.1117 -123.2552  7.7297  -0.2085 -0.1262 0.9698
    -142.7753 -119.2215  8.6075  -0.2246 -0.1305 0.9657
    -142.3714 -115.2108  9.5388  -0.2414 -0.1345 0.9611
    -141.9034 -111.2228 10.5266  -0.2588 -0.1381 0.9560
    -141.3725 -107.2568 11.5716  -0.2769 -0.1413 0.9505
    -140.7820 -103.3182 12.6719  -0.2954 -0.1442 0.9444
    -140.1377  -99.4070 13.8258  -0.3143 -0.1467 0.9379
    -139.4427  -95.5216 15.0328  -0.3333 -0.1488 0.9310
    -133.6968  -90.6636 18.2926  -0.3526 -0.1506 0.9236
"""
"""Tool tip [mm] and tool axis. Source: O. Tulsyan and Y. Altintas, Local toolpath smoothing for five-axis machine
tools, International Journal of Machine Tools and Manufacture 2015."""
S_POINTS, S_RADIUS, S_SWEEP, S_LEAN = 27, 45e-3, np.radians(160.0), np.radians(12.0)
"""Points of the S, radius [m] and sweep [rad] of its arcs, and how far the tool leans beside them [rad]."""
WAVE_BLOCKS = 400
"""Blocks from one side of the waves to the other."""
STEP = 24e-3
"""Length of straight blocks of the contour [m]."""


def s_shape(machine: Machine) -> ToolPath:
    """A pass along a wall in the form of an S: two arcs, beside which the tool leans to one side and to the other.

    The kind of wall that ISO 10791-7 tests five-axis machines with; form and lean are of our own.
    """
    u = np.linspace(-1.0, 1.0, S_POINTS)
    heading = S_SWEEP * (np.abs(u) - 0.5)
    x = np.sign(u) * S_RADIUS * (np.sin(heading) + np.sin(0.5 * S_SWEEP))
    y = np.sign(u) * S_RADIUS * (np.cos(0.5 * S_SWEEP) - np.cos(heading))
    lean = S_LEAN * np.sin(0.5 * np.pi * u)
    axis = np.stack([-np.sin(lean) * np.sin(heading), np.sin(lean) * np.cos(heading), np.cos(lean)], axis=1)
    return of_points(np.round(np.stack([x, y, np.zeros(S_POINTS)], axis=1), 7), axis)


def tulsyan(machine: Machine) -> ToolPath:
    """29 points of Tulsyan and Altintas."""
    return of_table(TULSYAN)


def contour(machine: Machine) -> ToolPath:
    """Three times round a wall of 120 by 80 mm with corners of 12 mm in 13 chords, leaning out by 15 to 25 degrees.

    The tool axis stands still on the sides and turns in the corners, as cutter-location data of contours have it.
    """
    tips, axes = [], []
    for level, lean in enumerate(np.radians([15.0, 20.0, 25.0])):
        for quarter in range(4):
            long, wide = ((60e-3, 40e-3), (40e-3, 60e-3))[quarter % 2]
            # a side along +y at x = wide, then the corner to the left, all turned by quarters
            count = round(2.0 * (long - 12e-3) / STEP)
            side = np.linspace(-(long - 12e-3), long - 12e-3, max(count, 1) + 1)
            angle = np.linspace(0.0, 0.5 * np.pi, 14)
            x = np.concatenate([np.full(len(side), wide), wide - 12e-3 + 12e-3 * np.cos(angle[1:])])
            y = np.concatenate([side, long - 12e-3 + 12e-3 * np.sin(angle[1:])])
            turn = np.concatenate([np.zeros(len(side)), angle[1:]]) + 0.5 * np.pi * quarter
            c, s = np.cos(0.5 * np.pi * quarter), np.sin(0.5 * np.pi * quarter)
            tips.append(np.stack([c * x - s * y, s * x + c * y, np.full(len(x), -2e-3 * level)], axis=1)[1:])
            out = np.stack([np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.full(len(x), np.cos(lean))])
            axes.append(out.T[1:])
    return of_points(np.round(np.concatenate(tips), 7), np.concatenate(axes))


def waves(blocks: int) -> str:
    """G-code of so many blocks of 0.3 mm to and fro over a wavy face of 120 by 80 mm, the tool leaning and turning."""
    lines = ["G21 G90 G43.4 H1 F3000"]
    passes = round(blocks / WAVE_BLOCKS)
    for k in range(passes):
        u = np.linspace(0.0, 1.0, WAVE_BLOCKS)[:: 1 if k % 2 == 0 else -1]
        columns = (
            120.0 * u - 60.0,
            np.full(WAVE_BLOCKS, 80.0 * k / passes - 40.0),
            4.0 * np.sin(6.0 * u + 0.02 * k) + 2.0 * np.cos(17.0 * u) - 20.0,
            8.0 * np.sin(4.0 * u + 0.01 * k) - 20.0,
            30.0 * np.cos(3.0 * u),
        )
        lines += [f"G1 X{x:.4f} Y{y:.4f} Z{z:.4f} A{a:.4f} C{c:.4f}" for x, y, z, a, c in zip(*columns)]
    return "\n".join([*lines, "G49", "M2", ""])


def of_table(text: str) -> ToolPath:
    """The points of a table, about the middle of the part."""
    rows = np.array(text.split(), dtype=float).reshape(-1, 6)
    tip = 1e-3 * rows[:, :3]
    return of_points(tip - 0.5 * (tip.min(axis=0) + tip.max(axis=0)), rows[:, 3:])


def of_points(tip: Floats, axis: Floats) -> ToolPath:
    """A tool path without feeds through tips (n, 3) [m] with tool axes (n, 3), at rest at its ends."""
    n = len(tip)
    stop = np.zeros(n, dtype=np.bool_)
    stop[[0, -1]] = True
    return ToolPath(
        tip=tip,
        axis=axis / np.linalg.norm(axis, axis=1)[:, None],
        feed=np.full(n, np.inf),
        least_time=np.zeros(n),
        block=np.arange(1, n + 1),
        stop=stop,
        dwell=np.zeros(n),
        blocks=n,
    )
