"""What edges of a tool take, tooth by tooth and step by step of a turn."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit

TURN = 2.0 * math.pi


class EdgePieces(NamedTuple):
    """p pieces of an edge, each in an arc of its surface that is in material."""

    entry: Floats
    """(p,) where the arc begins [rad]."""
    immersion: Floats
    """(p,) and how long it is [rad]."""
    outwards: Floats
    """(p, 3) how fast the surface moves along its normal: by the cosine and the sine of its angle, and at all [m/s]."""
    lag: Floats
    """(p,) of the edge behind its tip [rad]."""
    width: Floats
    """(p,) along the meridian [m]."""
    radius: Floats
    """(p,) [m]"""
    normal: Floats
    """(p, 2) of the surface, across the axis and up along it."""
    of_edge: Floats
    """(p,) share of the force of the edge that counts."""


class Teeth(NamedTuple):
    """k teeth, and what passed before each of them."""

    offset: Floats
    """(k,) of each from the first [rad]."""
    gone: Floats
    """(k, n) since each of n others passed [s]."""
    ahead: Floats
    """(k, n, 2) by how much further out it is than these: by the cosine and the sine of its lag [m]."""
    sense: float
    """1 where they turn clockwise, seen from the spindle, else -1."""
    force: Floats
    """(3, 2) tangential, radial and axial: per area of chip [Pa], and per length of edge [N/m]."""


class Turn(NamedTuple):
    """What is taken at the steps of a turn."""

    across: Floats
    """(2, steps, p) force on each piece along the feed and on its left [N]."""
    along: Floats
    """(steps, 4) force along the axis [N], torque [N m], area of chips [m2], length of edges in material [m]."""


@jit()
def turned(pieces: EdgePieces, teeth: Teeth, steps: int) -> Turn:
    """Turn all teeth through, once about."""
    count = len(pieces.entry)
    across, along = np.zeros((2, steps, count)), np.zeros((steps, 4))
    for p in range(count):
        normal, width, edge = pieces.normal[p], pieces.width[p], pieces.of_edge[p]
        cos_lag, sin_lag = math.cos(pieces.lag[p]), math.sin(pieces.lag[p])
        for tooth in range(len(teeth.offset)):
            for i in range(steps):
                phi = teeth.sense * TURN * i / steps + teeth.offset[tooth] - pieces.lag[p]
                on = (phi - pieces.entry[p]) % TURN
                if on >= pieces.immersion[p]:
                    continue
                cosine, sine = math.cos(phi), math.sin(phi)
                speed = pieces.outwards[p, 0] * cosine + pieces.outwards[p, 1] * sine + pieces.outwards[p, 2]
                chip = math.inf
                for m in range(teeth.gone.shape[1]):
                    ahead = teeth.ahead[tooth, m, 0] * cos_lag + teeth.ahead[tooth, m, 1] * sin_lag
                    chip = min(chip, speed * teeth.gone[tooth, m] + ahead * normal[0])
                if chip <= 0.0:
                    continue
                tangential = (teeth.force[0, 0] * chip + edge * teeth.force[0, 1]) * width
                radial = (teeth.force[1, 0] * chip + edge * teeth.force[1, 1]) * width
                axial = (teeth.force[2, 0] * chip + edge * teeth.force[2, 1]) * width
                # the radial force pushes the edge away from material, the axial one up along the meridian
                inwards = radial * normal[0] - axial * normal[1]
                across[0, i, p] += -inwards * sine - teeth.sense * tangential * cosine
                across[1, i, p] += -inwards * cosine + teeth.sense * tangential * sine
                along[i, 0] -= radial * normal[1] + axial * normal[0]
                along[i, 1] += tangential * pieces.radius[p]
                along[i, 2] += chip * width
                along[i, 3] += edge * width
    return Turn(across, along)
