"""A check of the limit utilisation that plan.json claims."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.judge.feed_check import FeedUse
from toolpace.judge.motion import TOLERANCE, limit_over_speed
from toolpace.judge.torque import JointTorques, rated_shares
from toolpace.judge.verification import Check
from toolpace.machine.limits import CONTINUOUS
from toolpace.machine.machine import Machine
from toolpace.motion.setpoints import SetPoints
from toolpace.programs.toolpath import ToolPath

SHARE = 0.04
"""By how much the share of time in which a limit binds may differ between set-points and all times."""
PRICES = 0.01
"""Of the time of motion, by which what the prices of limits sum to may differ from it: 2e-3 on the coarsest meshes."""
BINDING = 0.995
"""Share of a limit from which it counts as binding."""
TOGETHER = "all limits together"
"""Name of the share of time in which any limit binds."""
TIED = 1e-3
"""Share of a limit by which another may be used less than the one that is used most, and be the one that binds."""
LOOK = 1e-3
"""Share by which a peak may be higher than what is said of it: far below a limit, peaks are looked for at places."""
ROUNDED = 1e-5
"""Share of a jerk limit, held over the time steps between, by which columns of derivatives may be rounded: a tenth of
what is granted to the limit."""
DWELLS = 1e-9
"""The same for dwells, which are known."""
KINDS = ("velocity", "acceleration", "jerk")


def wrong(key: str, note: str, ok: bool = False) -> Check:
    """A figure that is no good by itself, or is."""
    return Check(f"plan.json {key}", 0.0, 0.0, "", ok, note=note)


@dataclass(frozen=True)
class UsageFigures:
    """The figures of usage, and what they are judged by."""

    said: Mapping[str, Any]
    """plan.json, key by key."""
    points: SetPoints
    machine: Machine
    toolpath: ToolPath | None
    feed_use: FeedUse | None
    """Of the tip; None where the program has no feeds, or was not judged."""
    dt: float
    """Time step of the set-points [s]."""

    def of_usage(self) -> list[Check]:
        """Peaks over limits: not below what the set-points show, not above what can hide between them."""
        usage, limits, dt = self.said["usage"], self.machine.limits.largest, self.dt
        checks = []
        above: list[float] = []
        values = (self.points.qd, self.points.qdd, self.points.qddd)
        for order, kind in enumerate(KINDS):
            if set(usage[kind]) != set(self.machine.joints):
                checks.append(wrong(f"usage {kind}", f"names {', '.join(usage[kind])}: not the machine's joints"))
                continue
            for j, joint in enumerate(self.machine.joints):
                limit, said = float(getattr(limits, kind)[j]), usage[kind][joint]
                said = math.inf if said is None else float(said)
                shown = float(np.abs(values[order][:, j]).max())
                # Between two set-points a value changes by half a step of the next one, at most.
                room = math.inf
                if order < 2:
                    next_kind = KINDS[order + 1]
                    next_limit = float(getattr(limits, next_kind)[j])
                    if math.isfinite(next_limit):
                        room = 0.5 * dt * next_limit * _number(usage[next_kind], joint)
                # Of a limit that is none, nothing is used; of one that no number of the plan bounds, too much.
                shares = (shown / limit, room / limit, self.rounding(j, order) / limit)
                peak, hidden, rounded = shares if math.isfinite(limit) else (0.0, 0.0, 0.0)
                least = peak * (1.0 - LOOK) - rounded - 1e-12
                most = min((peak + hidden) * (1.0 + TOLERANCE) + rounded + 1e-9, 1.0 + TOLERANCE)
                above.append(said)
                if not least <= said <= most:
                    note = f"by the set-points {least:.6g} to {most:.6g}"
                    checks.append(Check(f"plan.json usage {kind}", said, peak, "", False, joint=joint, note=note))
        checks += [*self.of_curves(), *self.of_motors(), *self.of_ratings(), *self.of_feed()]
        above += [float(value) for kind in ("curves", "motor", "continuous") for value in usage.get(kind, {}).values()]
        if not checks:
            worst = max([*above, float(usage["feed"])])
            checks.append(Check("plan.json usage", worst, 1.0, "", worst <= 1.0 + TOLERANCE, note="of each limit"))
        return checks

    def of_motors(self) -> list[Check]:
        """The use of torques and forces: not below that of the set-points, nor above it by more than its largest step
        between two of them."""
        said, torques, names = self.said["usage"].get("motor", {}), JointTorques(self.machine.file), self.machine.joints
        if set(said) != {name for name, held in zip(names, torques.held) if held}:
            return [wrong("usage motor", f"names {', '.join(said)}: not the joints whose motors have limits")]
        checks = []
        shares = self.motor_shares() if said else np.zeros((1, 0))
        for (joint, value), share in zip(said.items(), shares.T):
            least, change = float(share.max()), float(np.abs(np.diff(share)).max(initial=0.0))
            low, most = least * (1.0 - LOOK) - 1e-12, min((least + change) * (1.0 + TOLERANCE), 1.0 + TOLERANCE)
            if not low <= float(value) <= most:
                note = f"by the set-points {low:.6g} to {most:.6g}"
                checks.append(Check("plan.json usage motor", float(value), least, "", False, joint=joint, note=note))
        return checks

    def of_ratings(self) -> list[Check]:
        """The use of motors' continuous ratings, against the root mean square over the set-points."""
        said, torques, points = self.said["usage"].get("continuous", {}), JointTorques(self.machine.file), self.points
        if set(said) != {self.machine.joints[k] for k in torques.rated}:
            return [wrong("usage continuous", f"names {', '.join(said) or 'none'}: not the joints with a rating")]
        found = rated_shares(torques, points.t, torques.at(points.q, points.qd, points.qdd)) if said else []
        checks = []
        for joint, shown in zip(said, found):
            if not abs(float(said[joint]) - shown) <= LOOK * shown + TOLERANCE:
                note = f"by the set-points {shown:.6g}"
                checks.append(
                    Check("plan.json usage continuous", float(said[joint]), shown, "", False, joint=joint, note=note)
                )
        return checks

    def motor_shares(self) -> Floats:
        """(n, k) torques and forces at the set-points over their limits, of the joints that have one."""
        torques, points = JointTorques(self.machine.file), self.points
        return torques.shares(points.q, points.qd, points.qdd)[:, torques.held]

    @property
    def motors(self) -> list[str]:
        """Names of the limits of torque and force, in the order of the joints."""
        joints = self.machine.file.joints.items()
        return [
            f"{'force' if joint.kind == 'linear' else 'torque'} {name}"
            for name, joint in joints
            if joint.motor is not None
        ]

    def curve_shares(self) -> dict[str, Floats]:
        """(n,) what each set-point uses of each limit that falls with the speed of its joint, by name; nothing where it
        is at its largest value, which is a limit of its own."""
        limits, points, found = self.machine.limits, self.points, {}
        for curve in limits.curves:
            if curve.largest > curve.least:
                j, value = limits.joints.index(curve.joint), points.qdd if curve.kind == "acceleration" else points.qddd
                limit = limit_over_speed(curve, points.qd[:, j], value[:, j])
                found[curve.name] = np.where(limit < curve.largest, np.abs(value[:, j]) / limit, 0.0)
        return found

    def of_curves(self) -> list[Check]:
        """Peaks over limits that fall with the speed: not below what the set-points show, and within the limit."""
        said, shown = self.said["usage"].get("curves", {}), self.curve_shares()
        if set(said) != set(shown):
            return [wrong("usage curves", f"names {', '.join(said) or 'none'}: not the machine's curves")]
        checks = []
        for name, shares in shown.items():
            peak = float(shares.max(initial=0.0))
            if not peak * (1.0 - LOOK) - ROUNDED <= float(said[name]) <= 1.0 + TOLERANCE:
                note = f"{name}, by the set-points at least {peak:.6g}"
                checks.append(Check("plan.json usage curves", float(said[name]), peak, "", False, note=note))
        return checks

    def rounding(self, j: int, order: int) -> float:
        """By how much a joint's velocity, acceleration or jerk (order 0 to 2) may be off in the set-points.

        The smallest change of position that its limits allow in a step tells it.
        """
        limits = self.machine.limits.largest
        change = min(float(getattr(limits, kind)[j]) * self.dt**steps for steps, kind in enumerate(KINDS, 1))
        return ROUNDED * change / self.dt ** (order + 1)

    def of_feed(self) -> list[Check]:
        """The use of the feed."""
        said, use = float(self.said["usage"]["feed"]), self.feed_use
        if self.toolpath is None:
            return []
        # a profile of speed changes within a block, whose feed is the most of it
        timed = bool((self.toolpath.least_time > 0.0).any()) or self.toolpath.speed_profile is not None
        if use is None:
            least, most = 0.0, 1.0 if timed else 0.0
        else:
            least, most = use.least * (1.0 - TOLERANCE), 1.0 if timed else min(use.most, 1.0)
        if least - 1e-9 <= said <= most + TOLERANCE:
            return []
        note = f"by the set-points {least:.6g} to {most:.6g}"
        return [Check("plan.json usage feed", said, most, "", False, note=note)]

    def of_shares(self) -> list[Check]:
        """The limits that bind, and the share of the time in which each does."""
        said = {name: float(share) for name, share in self.said["limited_by"].items()}
        limits = ["feed", *(f"{kind} {joint}" for kind in KINDS for joint in self.machine.joints)]
        limits += [*self.curve_shares(), *self.motors]
        ratings = [CONTINUOUS + name for name in self.motors]
        profile = None if self.toolpath is None else self.toolpath.speed_profile
        loads = () if profile is None else profile.names
        strange = [name for name in said if name not in (*limits, *ratings, *loads, "dwell", "nothing")]
        total = sum(said.values())
        if strange or min(said.values(), default=0.0) < 0.0 or not abs(total - 1.0) <= 1e-6:
            note = f"names {', '.join(strange)}" if strange else f"shares add up to {total:.6g}, not to 1"
            return [wrong("limited_by", note)]
        checks = []
        if self.toolpath is not None:
            right = float(self.toolpath.dwell.sum()) / float(self.said["duration_s"])
            ok = abs(said.get("dwell", 0.0) - right) <= DWELLS
            checks.append(Check("plan.json limited_by dwell", said.get("dwell", 0.0), right, "", ok))
        timed = self.toolpath is not None and bool((self.toolpath.least_time > 0.0).any())
        if self.feed_use is None or timed or profile is not None:
            # What a block's least time or a profile holds back does not show in the speed of the tip over the feed.
            limits.remove("feed")
        least, most = self.shares(limits)
        shares = {name: said.get(name, 0.0) for name in limits}
        shares[TOGETHER] = sum(shares.values())
        off = {name: max(least[name] - share, share - most[name]) for name, share in shares.items()}
        worst = max(off, key=lambda name: off[name])
        granted = SHARE + 20.0 / len(self.points)
        between = f"{least[worst]:.4g}" + (f" to {most[worst]:.4g}" if most[worst] > least[worst] else "")
        note = f"{worst}: says {shares[worst]:.4g}, by the set-points {between}"
        passed = off[worst] <= granted
        return [*checks, Check("plan.json limited_by", max(off[worst], 0.0), granted, "", passed, note=note)]

    def of_prices(self) -> list[Check]:
        """What more of each limit would gain: k times the velocity, k^2 the acceleration and k^3 the jerk of a motion
        from rest to rest take 1 / k of its time, which fixes a sum of the prices."""
        said = {name: float(price) for name, price in self.said["prices_s"].items()}
        if not said:
            return []
        joints = self.machine.joints
        powers = {"feed": 1.0} | {f"{kind} {joint}": k for k, kind in enumerate(KINDS, 1) for joint in joints}
        curves = self.curve_shares()
        strange = [name for name in said if name not in powers and name not in (*curves, *self.motors)]
        if strange or not min(said.values()) >= 0.0:
            return [wrong("prices_s", f"names {', '.join(strange)}" if strange else "a price is below zero")]
        if any(said.get(name, 0.0) > 0.0 for name in curves):
            return []  # what falls with the speed is not as fast again on a faster machine
        moving = float(self.said["duration_s"]) - (0.0 if self.toolpath is None else float(self.toolpath.dwell.sum()))
        total = 100.0 * sum(powers[name] * price for name, price in said.items() if name in powers)
        ok = abs(total - moving) <= PRICES * moving
        if any(said.get(name, 0.0) > 0.0 for name in self.motors):
            # weight does not grow with the speed: what torques are worth beside the others is not fixed
            ok = total <= (1.0 + PRICES) * moving
        return [Check("plan.json prices_s", total, moving, "s", ok, note="their sum, against the time of motion")]

    def shares(self, names: list[str]) -> tuple[dict[str, float], dict[str, float]]:
        """The least and the largest share of each, and of all of them together, that the set-points show.

        Joints on a diagonal reach their limits at once: which of them binds is a matter of rounding.
        """
        points, limits = self.points, self.machine.limits.largest
        ratios = [np.zeros(len(points))]
        if self.feed_use is not None:
            use = self.feed_use.ratio
            ratios[0] = np.maximum(np.append(use, 0.0), np.append(0.0, use))
        kinds = zip((points.qd, points.qdd, points.qddd), (limits.velocity, limits.acceleration, limits.jerk))
        over_speed = self.curve_shares().values()
        ratio = np.column_stack([*ratios, *(np.abs(value) / limit for value, limit in kinds), *over_speed])
        ratio = np.column_stack([ratio, self.motor_shares()]) if self.motors else ratio
        if None in self.said["usage"]["jerk"].values():
            # Where accelerations jump, jerk limits are not held, and hold nothing back.
            ratio = ratio[:, : 1 + 2 * len(limits)]
        highest = ratio.max(axis=1, keepdims=True)
        binds = (highest >= BINDING) & (ratio >= highest - TIED)
        first = names.index(f"{KINDS[0]} {self.machine.joints[0]}")
        own, unjudged = binds[:, 1 - first :], binds[:, : 1 - first].any(axis=1)
        alone = own & (np.count_nonzero(binds, axis=1, keepdims=True) == 1)
        found = []
        for each, together in ((alone, own.any(axis=1) & ~unjudged), (own, own.any(axis=1))):
            share = dict.fromkeys(names, 0.0) | dict(zip(names, each.mean(axis=0).tolist()))
            found.append(share | {TOGETHER: float(together.mean())})
        return found[0], found[1]


def _number(values: Mapping[str, float | None], joint: str) -> float:
    value = values.get(joint)
    return math.inf if value is None else float(value)
