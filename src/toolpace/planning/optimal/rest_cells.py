"""Speed caps of the cells next to rest, where ds/dt has a constant third derivative."""

from __future__ import annotations

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits
from toolpace.motion import limit_ratios
from toolpace.motion.adaptive_sampling import unexplained
from toolpace.path.axis_run import AxisRun

REST_STATES, CLOSER_AT_REST = 65, 3
"""States of a rest cell that are looked at, and places of which the surroundings are looked at so again: on a coarse
mesh it is long."""


def rest_cap(run: AxisRun, limits: Limits, node: float, length: float, forth: bool) -> float:
    """Most z at the inner end of a rest cell, such that nothing inside the cell breaks a limit.

    It is looked at where its ends are near, where the path does more between two places than it tells at both, and then
    around the places that allow least.
    """
    share = (1.0 - np.cos(np.linspace(0.0, np.pi, REST_STATES))) / 2.0
    allowed = rest_caps(run, limits, node, length, forth, share)
    at_breaks = allowed[REST_STATES:].min(initial=np.inf)
    hidden, of_hidden = hidden_rest_caps(run, limits, node, length, forth, share, float(allowed.min()))
    share, allowed = np.append(share, hidden), np.append(allowed[:REST_STATES], of_hidden)
    for _ in range(2 if len(hidden) else 1):
        order = np.argsort(share, kind="stable")
        share, allowed = share[order], allowed[order]
        lowest, last = np.argsort(allowed)[:CLOSER_AT_REST], len(share) - 1
        low, high = share[np.maximum(lowest - 1, 0)], share[np.minimum(lowest + 1, last)]
        between = np.unique(np.linspace(low, high, REST_STATES))
        closer = rest_caps(run, limits, node, length, forth, between)[: len(between)]
        share, allowed = np.append(share, between), np.append(allowed, closer)
    return float(min(allowed.min(), at_breaks))


def hidden_rest_caps(
    run: AxisRun, limits: Limits, node: float, length: float, forth: bool, share: Floats, most: float
) -> tuple[Floats, Floats]:
    """Places between these ascending shares (k,) of a rest cell's time where the path does more than it tells there, at
    `most` so much z at the inner end; as such shares (n,), and most z by the limits at them (n,)."""
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    shares, caps = [np.empty(0)], [np.empty(0)]

    def path_at(places: Floats) -> Floats:
        return np.ascontiguousarray(run.evaluate(np.clip(places, run.s0, run.s1)))

    def look(places: Floats) -> tuple[Floats, Floats]:
        at = np.cbrt((places - rest) * sign / length)
        shares.append(at)
        caps.append(rest_caps(run, limits, node, length, forth, at)[: len(at)])
        return path_at(places), np.sqrt(most) * at * at

    s, speed = rest + sign * length * share**3, np.sqrt(most) * share * share
    s[-1] = node
    if not forth:
        s, speed = s[::-1].copy(), speed[::-1]
    path = path_at(s)
    low, high = (np.ascontiguousarray(part) for part in (path[:, :-1], path[:, 1:]))
    unexplained(run, limits, s[:-1], s[1:], low, high, np.maximum(speed[:-1], speed[1:]), look)
    return np.concatenate(shares), np.concatenate(caps)


def rest_caps(run: AxisRun, limits: Limits, node: float, length: float, forth: bool, share: Floats) -> Floats:
    """Most z at the inner end of a rest cell by the limits at shares (k,) of its time, and at both sides of breaks.

    All states of the cell scale with that z: speeds with its root, accelerations with it, jerks with its power 3/2.
    """
    sign = 1.0 if forth else -1.0
    rest = node - sign * length
    breaks = run.breaks[(run.breaks > min(rest, node)) & (run.breaks < max(rest, node))]
    inside = np.cbrt((breaks - rest) * sign / length)
    side = np.concatenate([np.where((share == 1.0) == forth, 0.0, 1.0), np.zeros(len(inside)), np.ones(len(inside))])
    third = 2.0 / (9.0 * length**2)
    t = 3.0 * length * np.concatenate([share, inside, inside])
    state = np.stack([rest + sign * third * t**3 / 6.0, third * t**2 / 2.0, sign * third * t, np.full(len(t), third)])
    # rounded, the node could lie beyond a break that is there, and the breaks on the other side of themselves
    state[0, : len(share)][share == 1.0], state[0, len(share) :] = node, np.tile(breaks, 2)
    ratios = np.maximum(limit_ratios(run, limits, state, side), 1e-100)
    m = len(limits)
    allowed = (
        ratios[:, : 1 + m].max(axis=1) ** -2.0,
        1.0 / ratios[:, 1 + m : 1 + 2 * m].max(axis=1),
        ratios[:, 1 + 2 * m :].max(axis=1) ** (-2.0 / 3.0),
    )
    least: Floats = np.minimum.reduce(allowed)
    return least
