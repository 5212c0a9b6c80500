"""Tool paths and limits that papers print as tables, on one five-axis machine."""

from __future__ import annotations

import numpy as np

from testbed.jets import Remembered
from toolpace.common.arrays import Floats
from toolpace.machine.limits import Limits
from toolpace.machine.machine import Machine
from toolpace.path.path import Path
from toolpace.path.run import unit_jets

JOINTS = ("X", "Y", "Z", "A", "C")
FLANK_KNOTS = (0, 0, 0, 0, 0.2, 0.4, 0.6, 0.8, 1, 1, 1, 1)
FLANK_TIP = ((5, 0, 0), (-10, 20, 0), (10, 20, 0), (20, 30, 0), (30, 30, 0), (40, 30, 0), (50, 20, 0), (55, 0, 0))
FLANK_POINT = (
    (0, 0, 15), (-15, 20, 15), (5, 25, 15), (15, 35, 15), (30, 35, 15), (45, 35, 15), (55, 25, 15), (60, 0, 15),
)  # fmt: skip
"""Control points of the tool tip, and of a second point on the tool axis [mm]."""
FAN = """
    113.5608    7.7353 -2.2093 -0.1073  0.6249 0.7733
    117.8649  -10.9501 -0.9741 -0.0030  0.6530 0.7573
    115.5029  -34.8088  0.7796  0.1350  0.6488 0.7489
    104.0860  -55.8401  2.6826  0.2639  0.5968 0.7578
     95.2257  -63.9596  4.0735  0.3172  0.5518 0.7713
     88.8206  -65.9723  6.0218  0.3295  0.5161 0.7906
     80.1628  -65.0964  7.0315  0.3268  0.4780 0.8153
     72.4782  -61.1095  6.8631  0.3137  0.4461 0.8382
     65.9858  -54.6664  6.1430  0.2887  0.4164 0.8621
     54.2520  -39.5681  4.9312  0.2170  0.3575 0.9084
     38.0390  -23.1115  3.5361  0.1295  0.2618 0.9564
     31.6791  -18.7113  3.0176  0.1055  0.2209 0.9696
     26.1926  -16.7813  2.4549  0.0968  0.1849 0.9780
     22.3378  -16.4864  1.9074  0.0979  0.1597 0.9823
     18.7698  -17.9379  0.2587  0.1106  0.1379 0.9843
     17.0042  -21.3334 -1.3755  0.1335  0.1275 0.9828
     16.7631  -27.0829 -2.5738  0.1711  0.1277 0.9769
     20.0593  -38.2107 -3.5736  0.2390  0.1533 0.9588
     26.9912  -67.7863 -5.5703  0.3999  0.2013 0.8942
     28.0807  -86.6480 -6.2051  0.4879  0.2082 0.8477
     21.8131 -103.5714 -4.4425  0.5679  0.1822 0.8027
      6.1563 -114.1796 -2.0441  0.6287  0.0985 0.7714
    -12.6615 -117.9888 -0.8723  0.6542 -0.0066 0.7563
    -31.8162 -116.3240  0.5145  0.6520 -0.1172 0.7491
    -49.4389 -108.7844  2.0895  0.6189 -0.2239 0.7529
"""
"""Tool tip [mm] and tool axis."""


def trunnion(limits: Limits) -> Machine:
    """The papers' machines are not given: taken is an A/C table-table one, its axes 70 mm below the part's origin."""
    return Machine.load("xyzac-trunnion").with_limits(limits)


def flank() -> tuple[Path, Machine]:
    """A flank pass, given as two cubic B-splines; their third derivatives jump at the knots.

    Source: H.-Y. Ma et al., Optimal feedrate planning on a five-axis parametric tool path with global geometric and
    kinematic constraints, Journal of Computational Design and Engineering 2022, appendix 1 and table 4.
    """
    limits = Limits([0.1, 0.1, 0.1, 0.4, 0.8], 0.5, [3.0, 3.0, 3.0, 1.5, 1.5], JOINTS)
    path = Path.from_bspline(
        np.array(FLANK_KNOTS, dtype=float), 1e-3 * np.array(FLANK_TIP), 1e-3 * np.array(FLANK_POINT), 3
    )
    return path, trunnion(limits)


def fan() -> tuple[Path, Machine]:
    """25 points at 50 mm/s, joined by a natural spline of degree seven over the square root of the chords.

    Source: Y. Zhang et al., Feedrate blending method for five-axis linear tool path, IJMS 2021, tables B.1 and 1. No
    velocity limits are given.
    """
    from scipy.interpolate import make_interp_spline

    points = np.array(FAN.split(), dtype=float).reshape(-1, 6)
    points[:, :3] *= 1e-3
    points[:, 3:] /= np.linalg.norm(points[:, 3:], axis=1)[:, None]
    chord = np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(np.sqrt(chord))])
    natural = [(order, np.zeros(6)) for order in (4, 5, 6)]
    spline = make_interp_spline(place / place[-1], points, k=7, bc_type=(natural, natural))

    def jets(s: Floats) -> Floats:
        raw = np.stack([spline(s, order) for order in range(4)])
        return np.concatenate([raw[:, :, :3], unit_jets(raw[:, :, 3:])], axis=2)

    remembered = Remembered(jets)

    def f(s: Floats, order: int) -> tuple[Floats, Floats]:
        value = remembered(s, order)
        return value[:, :3], value[:, 3:]

    acceleration = [0.5, 0.5, 0.4, np.radians(300), np.radians(500)]
    jerk = [5.0, 5.0, 4.0, np.radians(3000), np.radians(5000)]
    return Path.from_callable(f, feed=0.05), trunnion(Limits(np.inf, acceleration, jerk, JOINTS))
