"""Cutting forces by turning the tool through time: written apart from the library's, with nothing of it but its tables.

The tool turns in steps. At each step every tooth is cut into short pieces of the height. A piece that is in an arc of
its slice cuts as far as it reaches beyond where the teeth ahead of it went: by their true (trochoidal) ways, or with
the tool taken to turn about a point that stands while they do (circular).
"""

from __future__ import annotations

import numpy as np


def radius_at(tool, z):
    """Radius of the cutting part at heights (n,), closed form by kind."""
    half, corner = 0.5 * tool.diameter, tool.corner_radius
    if tool.kind == "drill":
        return np.minimum(z * np.tan(0.5 * tool.point_angle), half)
    if tool.kind == "taper":
        corner, slope = tool.corner_radius, np.tan(tool.taper)
        up = corner * (1.0 - np.sin(tool.taper))
        on_cone = half - corner * (1.0 - np.cos(tool.taper)) + (z - up) * slope
        on_tip = half - corner + np.sqrt(np.maximum(corner**2 - (corner - z) ** 2, 0.0))
        return np.where(z < up, on_tip, on_cone)
    if tool.kind == "lens":
        end = tool.barrel_radius
        height = end - np.sqrt((end - corner) ** 2 - (half - corner) ** 2)
        touch = end - (end - height) * end / (end - corner)
        rounded = half - corner + np.sqrt(np.maximum(corner**2 - np.maximum(height - z, 0.0) ** 2, 0.0))
        return np.where(z < touch, np.sqrt(2.0 * end * z - z**2), rounded)
    corner = half if tool.kind == "ball" else corner
    if corner == 0.0:
        return np.full_like(z, half)
    return half - corner + np.sqrt(np.maximum(corner**2 - np.maximum(corner - z, 0.0) ** 2, 0.0))


def turned_tool(tool, coefficients, engagement, i, speed, spindle, steps=5760, trochoidal=False, phase=0.0,
                bend=None, fine=False):  # fmt: skip
    """Forces (steps, 3) [N] along feed, normal and axis, and torque (steps,) [N m], of station i over a turn.

    speed of the tip [m/s]; phase: angle of the runout from the first tooth. With `bend`, a function of heights (n,)
    that gives (w, n) deflections per force there, also deflections (steps, w, 2) along feed and normal [m].
    fine: pieces of a third, without which peaks are up to 4 percent off where arcs are short.
    """
    k, sense = coefficients, 1.0 if tool.clockwise else -1.0
    count = tool.teeth
    pitch = np.array(tool.pitch) if tool.pitch else np.full(count, 2.0 * np.pi / count)
    offset = sense * np.concatenate([[0.0], np.cumsum(pitch)[:-1]])
    turn = 1.0 / spindle
    velocity = speed * np.array([engagement.across[i], 0.0, engagement.along[i]])
    theta = sense * 2.0 * np.pi * np.arange(steps) / steps
    force, torque = np.zeros((steps, 3)), np.zeros(steps)
    bent = None if bend is None else np.zeros((steps, len(bend(np.zeros(1))), 2))
    slope = 2.0 * np.tan(tool.helix) / tool.diameter
    # a piece lags by a tenth of a degree at most
    lag, least = (np.radians(0.03), 100) if fine else (np.radians(0.1), 30)
    pieces = max(int(abs(slope) * engagement.slice_height / lag), least)
    for a in range(engagement.first_arc[i], engagement.first_arc[i + 1]):
        low = engagement.slice[a] * engagement.slice_height
        # finer towards the tip, where the surface of a ball turns
        edges = low + engagement.slice_height * np.linspace(0.0, 1.0, pieces + 1) ** (2.0 if low == 0.0 else 1.0)
        rim = radius_at(tool, edges)
        along, outwards = np.diff(edges), np.diff(rim)
        length = np.hypot(along, outwards)
        sine, cosine = along / length, outwards / length
        z, r = 0.5 * (edges[1:] + edges[:-1]), 0.5 * (rim[1:] + rim[:-1])
        lag = slope * z

        # of each tooth the radius at which it goes about the spindle's axis, and how much that grows with the height
        reach = r + tool.runout * np.cos(sense * phase - offset[:, None] + lag)
        growth = outwards / along

        for tooth in range(count):
            phi = theta[:, None] + offset[tooth] - lag
            turned = (phi - engagement.entry[a]) % (2.0 * np.pi)
            at, piece = np.nonzero(turned < engagement.exit[a] - engagement.entry[a])
            phi = phi[at, piece]
            x, y = np.sin(phi), np.cos(phi)
            left = np.full_like(phi, -np.inf)
            gone = 0.0
            for m in range(1, count + 1):
                other = (tooth + m) % count
                gone += pitch[(tooth + m - 1) % count] / (2.0 * np.pi) * turn
                ago = np.full_like(phi, gone)
                for _ in range(4 if trochoidal else 1):
                    # what was at this height of the stock was higher up the tool while that was lower
                    ahead, higher = -velocity[0] * ago, velocity[2] * ago
                    far = reach[other, piece] + growth[piece] * higher
                    if not trochoidal:
                        distance = far + ahead * x
                        break
                    # the point of the way of the other tooth in the direction phi as seen from the axis of now
                    angle = phi + sense * 2.0 * np.pi * spindle * (gone - ago)
                    px, py = ahead + far * np.sin(angle), far * np.cos(angle)
                    distance = np.hypot(px, py)
                    ago = ago + sense * (np.arctan2(px * y - py * x, px * x + py * y)) / (2.0 * np.pi * spindle)
                left = np.maximum(left, distance)
            chip = (reach[tooth, piece] - left) * sine[piece]
            cut = chip > 0.0
            h, width = np.where(cut, chip, 0.0), cut * length[piece]
            tangential = (k.tangential * h + k.tangential_edge) * width
            radial = (k.radial * h + k.radial_edge) * width
            axial = (k.axial * h + k.axial_edge) * width
            inwards = radial * sine[piece] + axial * cosine[piece]
            for column, part in enumerate(
                (
                    -(inwards * x + sense * tangential * y),
                    sense * tangential * x - inwards * y,
                    radial * cosine[piece] - axial * sine[piece],
                )
            ):
                force[:, column] += np.bincount(at, part, minlength=steps)
                if bent is not None and column < 2:
                    for w, weight in enumerate(bend(z)):
                        bent[:, w, column] += np.bincount(at, part * weight[piece], minlength=steps)
            torque += np.bincount(at, tangential * r[piece], minlength=steps)
    return (force, torque) if bent is None else (force, torque, bent)
