"""Forbidden zones: boxes of joint positions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpace.common.arrays import Bools, numbers
from toolpace.common.errors import UsageError, did_you_mean
from toolpace.common.units import FARTHEST_PART, METRES, refuse_other_unit


@dataclass(frozen=True)
class Zone:
    """Joint positions between bounds; a joint that is not named may be anywhere."""

    name: str
    bounds: Mapping[str, tuple[float, float]]
    """Lowest and highest position by joint [m or rad], inf where there is no end."""

    def __post_init__(self) -> None:
        for joint, (low, high) in self.bounds.items():
            if not low <= high:
                raise UsageError(f"zone {self.name}: {joint} from {low:g} to {high:g}; give the lower one first")
            if not is_angle(joint):
                for each in (low, high):
                    refuse_other_unit(each, FARTHEST_PART, f"zone {self.name}: {joint}", METRES)

    def entered(self, joints: tuple[str, ...], q: npt.ArrayLike) -> Bools:
        """(n - 1,) which of the straight ways between joint positions q (n, joints) enter it: by slabs."""
        for joint in self.bounds:
            if joint not in joints:
                raise UsageError(f"zone {self.name}: there is no joint {joint[:40]}; {did_you_mean(joint, joints)}")
        q = numbers(q, f"zone {self.name}: q", ("n", len(joints)), unit="m, rad")
        if not len(q):
            return np.zeros(0, dtype=np.bool_)
        first, last = np.zeros(len(q) - 1), np.ones(len(q) - 1)
        for joint, (low, high) in self.bounds.items():
            at, way = q[:-1, joints.index(joint)], np.diff(q[:, joints.index(joint)])
            with np.errstate(divide="ignore", invalid="ignore"):
                ends = np.stack([(low - at) / way, (high - at) / way])
            stands = np.abs(way) < 1e-15
            inside = (at >= low) & (at <= high)
            ends[:, stands] = np.where(inside[stands], [[-math.inf], [math.inf]], [[math.inf], [-math.inf]])
            first, last = np.maximum(first, ends.min(axis=0)), np.minimum(last, ends.max(axis=0))
            # what stands outside of a slab is outside of the box
            last[stands & ~inside] = -math.inf
        return np.asarray(first <= last)


def is_angle(joint: str) -> bool:
    """Whether the positions of a joint are angles, by its name, as a file of choices has them."""
    return joint[:1] in ("A", "B", "C")
