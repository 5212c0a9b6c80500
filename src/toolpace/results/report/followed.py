"""A page that replays a follower's record: tip error, pace, utilisation."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.common.errors import UsageError
from toolpace.common.files import whole_file
from toolpace.common.units import format_time
from toolpace.machine.limits import KINDS
from toolpace.machine.machine import Machine, check_machine
from toolpace.results.report import shell
from toolpace.results.report.charts import extremes

if TYPE_CHECKING:
    from toolpace.deflection.following import SetPoint

SCRIPTS = ("playback", "tracks", "run", "program", "transport")
"""Scripts of the player on which that of the page stands."""
CURVE = 6000
"""Points of each curve over time."""
WAY = 3000
"""Places of the path in the plane."""
SEEN = 0.04
"""How large the largest error is drawn, as a share of the path's extent."""
SETTLED = 0.1
"""Time after the first disturbance from which an rms is told [s]."""


def follow_report(
    path: str | os.PathLike[str],
    setpoints: Sequence[SetPoint],
    machine: Machine,
    errors: Mapping[str, Floats],
    title: str = "A plan followed live",
) -> None:
    """Write a page of a run as one HTML file, whole or not at all; it opens without a network.

    setpoints: what `Follower.step` gave, in order. errors: by name (n, 3), what the tip was off by at each of them [m],
    with correction and without as a rule, as measured or simulated; the first is drawn strongest.
    Raises UsageError where there are no set-points or their number differs.
    """
    check_machine(machine, "follow_report")
    if not setpoints or any(np.shape(error) != (len(setpoints), 3) for error in errors.values()):
        shapes = ", ".join(f"{name} {np.shape(error)}" for name, error in errors.items())
        raise UsageError(
            f"follow_report: {len(setpoints)} set-points, errors of shape {shapes}; give (n, 3) for each n"
        )
    with whole_file(path) as temporary:
        temporary.write_text(_page(setpoints, machine, errors, title), encoding="utf-8")


def limit_shares(setpoints: Sequence[SetPoint], machine: Machine) -> dict[str, Floats]:
    """By kind (3, n): what path, correction and both use of the limit, each of the joint that uses most of it."""
    own = np.array([each.correction[1:] for each in setpoints])
    whole = np.array([(each.qd, each.qdd, each.qddd) for each in setpoints])
    limits = np.array([machine.limits.velocity, machine.limits.acceleration, machine.limits.jerk])
    used = np.abs(np.stack([whole - own, own, whole])) / limits
    return {kind: used[:, :, k].max(axis=2) for k, kind in enumerate(KINDS)}


def _page(setpoints: Sequence[SetPoint], machine: Machine, errors: Mapping[str, Floats], title: str) -> str:
    used = limit_shares(setpoints, machine)
    fields = {
        "machine": escape(machine.name),
        "cards": _cards(setpoints, used, errors),
        "points": f"{len(setpoints):,}".replace(",", " "),
    }
    data, times = _data(setpoints, machine, used, errors)
    magnified = f"What the tip is off by is drawn {times:,.0f} times as large." if errors else ""
    fields["magnified"] = magnified
    return shell.whole_page("toolpace.results.report", "followed", title, fields, data, SCRIPTS)


def _cards(setpoints: Sequence[SetPoint], used: Mapping[str, Floats], errors: Mapping[str, Floats]) -> str:
    """The figures of the run."""
    t = np.array([each.t for each in setpoints])
    pace = np.array([each.pace for each in setpoints])
    worst = max(used, key=lambda kind: float(used[kind][2].max()))
    cards = [("Time", format_time(t[-1]), f"up to {format_time(setpoints[-1].path_time)} of the plan")]
    for name, error in errors.items():
        size = 1e6 * _finite(np.linalg.norm(error, axis=1))
        begun = np.flatnonzero(size > 0.05 * size.max())
        settled = size[t >= t[begun[0] if len(begun) else 0] + SETTLED]
        rms = float(np.sqrt((settled**2).mean())) if len(settled) else 0.0
        note = f"root mean square, from {SETTLED * 1e3:.0f} ms after its beginning; at most {size.max():.0f} µm"
        cards.append((f"Error {name}", f"{rms:.1f} µm", note))
    cards.append(("Highest use of a limit", f"{100.0 * used[worst][2].max():.1f} %", f"{worst}, path and correction"))
    cards.append(("Pace", f"{pace.min():.2f} to {pace.max():.2f}", "share of the plan's speed"))
    return shell.cards((*card, "" if k else "big") for k, card in enumerate(cards))


def _data(
    setpoints: Sequence[SetPoint], machine: Machine, used: Mapping[str, Floats], errors: Mapping[str, Floats]
) -> tuple[str, float]:
    """All that the script draws, as JSON that cannot end the element it stands in; and how many times as large as it is
    an error is drawn."""
    q = np.array([each.q - each.correction[0] for each in setpoints])
    at = np.linspace(0, len(q) - 1, min(len(q), WAY)).astype(np.int64)
    tip = machine.forward(q[at])[0]
    middle = tip - tip.mean(axis=0)
    # the plane in which the path is widest
    across = np.linalg.svd(middle, full_matrices=False)[2][:2]
    extent = float(np.ptp(middle @ across.T, axis=0).max())
    sizes = [_finite(np.linalg.norm(error, axis=1)) for error in errors.values()]
    largest = max((float(size.max()) for size in sizes), default=0.0)
    times = round_down(SEEN * extent / largest) if largest > 0.0 else 1.0
    data = {
        "end": float(setpoints[-1].t),
        "errors": {name: _curve(1e6 * np.linalg.norm(error, axis=1)) for name, error in errors.items()},
        "pace": _curve(np.array([each.pace for each in setpoints])),
        "used": {kind: [_curve(100.0 * row) for row in rows] for kind, rows in used.items()},
        "way": _plane(middle, across),
        "off": {name: _plane(middle + times * _finite(error[at]), across) for name, error in errors.items()},
    }
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c"), times


def _finite(values: Floats) -> Floats:
    """The same with 0 for what was not measured."""
    return np.where(np.isfinite(values), values, 0.0)


def _curve(values: Floats) -> list[float | None]:
    """None where an error was not measured."""
    return [float(f"{value:.5g}") if math.isfinite(value) else None for value in extremes(values, CURVE)]


def _plane(points: Floats, across: Floats) -> list[list[float]]:
    """Places (n, 3) in the plane of `across` (2, 3) [mm]."""
    return [[float(f"{value:.6g}") for value in 1e3 * points @ direction] for direction in across]


def round_down(value: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is no more; at least 1."""
    power = 10.0 ** np.floor(np.log10(max(value, 1.0)))
    return float(max(power * step for step in (1.0, 2.0, 5.0) if power * step <= max(value, 1.0)))
