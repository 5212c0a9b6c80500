"""Tables of engagement as tests write them: one station or many, the same arc in all slices, or arcs at random."""

from __future__ import annotations

import numpy as np

from toolpace.cutting.engagement.table import EngagementTable
from toolpace.programs.tool_figures import ToolFigures


def engagement(arcs, slice_height, across=1.0, along=0.0, bottom=0.0, stations=1):
    """The same at all stations: arcs are (slice, entry, exit)."""
    k = len(arcs)
    rows = np.array(arcs, dtype=float).reshape(k, 3)
    return EngagementTable(
        slice_height=slice_height,
        feed_direction=np.tile([1.0, 0.0, 0.0], (stations, 1)),
        across=np.full(stations, across),
        along=np.full(stations, along),
        first_arc=np.arange(stations + 1) * k,
        slice=np.tile(rows[:, 0].astype(np.int64), stations),
        entry=np.tile(rows[:, 1], stations),
        exit=np.tile(rows[:, 2], stations),
        bottom=np.full(stations, bottom),
        removed=np.zeros(stations),
        width=np.zeros(stations),
        depth=np.full(stations, slice_height * (1.0 + rows[:, 0].max(initial=-1.0))),
    )


def shoulder(depth, entry, leave, slices=20, **more):
    """One arc in all slices of a depth [m]."""
    return engagement([(j, entry, leave) for j in range(slices)], depth / slices, **more)


def random_tool(rng):
    """Any kind of mill, with even or uneven teeth, runout, either sense."""
    diameter = rng.uniform(4e-3, 20e-3)
    kind = rng.choice(["flat", "bull", "ball", "taper"])
    teeth = int(rng.integers(1, 5))
    pitch = ()
    if teeth > 1 and rng.random() < 0.3:
        angles = rng.uniform(0.8, 1.2, teeth)
        pitch = tuple(2.0 * np.pi * angles / angles.sum())
    sense = 1.0 if rng.random() < 0.7 else -1.0
    return ToolFigures(
        kind,
        diameter,
        corner_radius={"bull": 0.2 * diameter, "taper": 0.45 * diameter}.get(kind, 0.0),
        taper=np.radians(rng.uniform(2.0, 10.0)) if kind == "taper" else 0.0,
        teeth=teeth,
        pitch=pitch,
        helix=sense * np.radians(rng.choice([0.0, 20.0, 35.0, 50.0])),
        runout=rng.choice([0.0, 2e-6, 10e-6]),
        stick_out=4.0 * diameter,
        flute_length=2.0 * diameter,
        material="carbide",
        clockwise=sense > 0.0,
    )


def random_engagement(rng, tool):
    """One station with arcs that change from slice to slice, of a motion across, down or up a slope."""
    slices = int(rng.integers(2, 12))
    tilt = np.radians(rng.choice([0.0, -20.0, -3.0, 4.0, 15.0]))
    entry, wide = rng.uniform(0.0, np.pi), rng.uniform(0.3, np.pi)
    arcs = []
    for j in range(slices):
        arcs.append((j, entry % (2.0 * np.pi), entry % (2.0 * np.pi) + wide))
        if rng.random() < 0.2:
            arcs.append((j, (entry + wide + 0.3) % (2.0 * np.pi), (entry + wide + 0.3) % (2.0 * np.pi) + 0.4))
        entry, wide = entry + rng.normal(0.0, 0.05), np.clip(wide + rng.normal(0.0, 0.05), 0.2, 4.5)
    depth = rng.uniform(0.1, 0.8) * tool.diameter
    return engagement(arcs, depth / slices, np.cos(tilt), np.sin(tilt))
