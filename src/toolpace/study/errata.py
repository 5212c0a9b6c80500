# ruff: noqa: RUF001 - minus signs and primes, as formulas are set
"""What the paper prints, what holds, and the check of it, line by line, worked out anew each time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.axispath.axispath import AxisPath
from toolpace.kernels.motion import quintic
from toolpace.study.simulation import DEFLECTION, FEED, PRINTED_PROJECTION, Study

LENGTH, Z1, Z2 = 0.05, 0.3, 0.03
"""Tool length and structure, section III [m]."""


@dataclass(frozen=True)
class Erratum:
    """One line of the table."""

    where: str
    printed: str
    holds: str
    check: str


def all_errata(study: Study) -> list[Erratum]:
    """All lines, in the order of the paper."""
    run = AxisPath.follow(study.path, study.machine).runs[0]
    s = np.linspace(run.s0, run.s1, 1001)
    columns = [study.machine.joints.index(name) for name in "XYZAB"]
    x, y, z, a, b = run.evaluate(s)[0][:, columns].T
    tip = study.path.runs[0].evaluate(s).tip[0]
    # Eq. (1): T_t^lg P_t for both signs of l_t, against Eq. (2)
    wrong = np.abs(
        np.stack([-LENGTH * np.sin(a), LENGTH * np.cos(a)]) - np.stack([LENGTH * np.sin(a), -LENGTH * np.cos(a)])
    ).max()
    # Eq. (5) and both forms of Eq. (6)
    reach = Z1 + z - LENGTH * np.cos(a)
    forward = np.stack([-x - reach * np.sin(b), LENGTH * np.sin(a) - y, reach * np.cos(b) - Z2], axis=1)
    inverse = (Z2 + tip[:, 2]) / np.cos(b) - Z1
    printed_z, right_z = inverse + LENGTH * np.sin(a), inverse + LENGTH * np.cos(a)
    # Eq. (7b) on the first interval, with and without the half in D3
    jets = study.path.runs[0].evaluate(study.points[:2]).tip
    h = float(study.points[1])
    start, end = jets[2, :, 0] * h * h
    # Eq. (7e) at the start: the printed terms vanish at rest
    state = study.optimal.laws[0].at(np.zeros(1))
    rates = state[1:]
    joints = run.evaluate(state[0])
    full = np.abs(quintic.axis_motion(joints, rates)[2]).max()
    printed_jerk = np.abs(joints[3] * rates[0][:, None] ** 3 + 3.0 * joints[2] * (rates[0] * rates[1])[:, None]).max()
    projection = np.array(PRINTED_PROJECTION)
    centre = np.array([0.0707, 0.0707, 0.0])
    ours, whole = study.interval, study.whole
    return [
        Erratum("II.B, point P_t", "(0, 0, l_t, 1)", "(0, 0, −l_t, 1)",
                f"only so does Eq. (1) give Eq. (2); as printed it is off by up to {1e3 * wrong:.0f} mm"),
        Erratum("Eq. (1), (2)", "tip in the lower-ground frame", "right as printed",
                "Eq. (2) follows from Eq. (1) with the point above"),
        Erratum("Eq. (3) to (5)", "forward kinematics", "right as printed",
                f"the machine paper-ab agrees along the arc to {np.abs(forward - tip).max():.1e} m"),
        Erratum("Eq. (6), third line", "z_gt = … + l_t sin A − z₁", "z_gt = … + l_t cos A − z₁",
                f"as printed off by up to {1e3 * np.abs(printed_z - z).max():.1f} mm; put right, by"
                f" {np.abs(right_z - z).max():.1e} m"),
        Erratum("Eq. (7b), D₃", "r(k+1)″ − 2 C₂", "(r(k+1)″ − 2 C₂) / 2",
                f"as printed the second derivative at the end of interval 1 is {1e6 * (2 * end - start):.4f} µm"
                f" instead of {1e6 * end:.4f} µm (x, by u)"),
        Erratum("Eq. (7d)", "o(T_i), and [z_w(i)]′ for [z_w(i)′]", "o(T_i²); a misprint",
                "Taylor's remainder after the square; the next term is of third order"),
        Erratum("Eq. (7e)", "J = w‴u̇³ + 3 w″u̇ü", "+ w′ d³u/dt³",
                f"at the start of the optimal motion the printed terms give {printed_jerk:.3g}, all three {full:.4g}"
                " m/s³ or rad/s³"),
        Erratum("III, the circle", "centre (0.0707, 0.0707, 0), radius 0.1 m", "centre at the origin, plane x = y",
                f"the printed projection is {np.linalg.norm(projection):.5f} m from the origin and"
                f" {np.linalg.norm(projection - centre):.4f} m from the printed centre"),
        Erratum("III, “20th interval”", "projection (0.058, 0.058, 0.0571)",
                f"({', '.join(f'{v:.5f}' for v in ours.tip)}), the first point of the 20th of 31 intervals",
                f"{1e3 * ours.distance:.3f} mm away; u clipped to [0, 1]; every printed digit is met"),
        Erratum("III, the projection", "called the projection on the curve",
                f"({', '.join(f'{v:.5f}' for v in whole.tip)}), in the 19th interval",
                f"{1e3 * whole.distance:.3f} mm away, against {1e3 * ours.distance:.3f} mm of the printed point"),
    ]  # fmt: skip


def comparison(study: Study) -> list[tuple[str, str, str]]:
    """Quantity, as printed, ours."""
    peaks = {name: (a.usage().worst, b.usage().worst) for name, (a, b) in study.pairs().items()}

    def triple(values: tuple[float, ...] | np.ndarray, digits: int) -> str:
        return f"({', '.join(f'{v:.{digits}g}' for v in values)}) m"

    length = float(study.points[-1])
    return [
        ("Tool length l_t; z₁; z₂", "0.05 m; 0.3 m; 0.03 m", "the same"),
        ("Feed rate limit F", "0.03 m/s", f"{FEED:g} m/s"),
        ("Velocity, acceleration, jerk of each motor", "0.5, 20, 200 (m or rad)", "the same"),
        ("Intervals", "31", f"{len(study.points) - 1}, of {1e3 * length / 31:.3f} mm each"),
        ("Length of the curve", "–", f"{length:.6f} m"),
        ("Deflection", "(0.059, 0.0568, 0.0589) m", triple(np.array(DEFLECTION), 4)),
        ("Projection on the 20th interval", "(0.058, 0.058, 0.0571) m", triple(study.interval.tip, 4)),
        ("Projection on the whole curve", "–", triple(study.whole.tip, 6)),
        ("All limits held without deflection", "yes (Fig. 6, 7)",
         "; ".join(f"{name}: peak use {without:.5f}" for name, (without, _) in peaks.items())),
        ("All limits held with deflection", "yes (Fig. 9, 10)",
         "; ".join(f"{name}: peak use {back:.5f}" for name, (_, back) in peaks.items())),
        ("Total time", "not printed", "see the table of times"),
    ]  # fmt: skip


CHOICES = [
    ("Tool axis", "a constant lead angle to the tangent in the plane of the curve, 45° off the outward normal, so it"
     " turns from −45° to +45°. The tangent itself and the normal are impossible: tan B and sec B are infinite there."
     " A stays within ±30°, B within ±35.3°."),
    ("Preset speeds", "98 percent of what jerk-limited ramps and the limits at each reference point allow, from rest to"
     " rest, lowered where an interval has no law within the limits; accelerations follow from the speeds."),
    ("Genetic algorithm", "one gene a period, 15 bits, population 20, tournaments of two, one-point crossover (0.8),"
     " 2 percent of the bits flipped, the best lives on, seed 2009. The first population holds one comfortable period;"
     " the others are random between 0.7 and 1.6 times that of the mean speed."),
    ("Periods held to the limits", "at 33 points of every interval, checked at 65 on both sides of each reference"
     " point, and tightened where a limit is passed between."),
    ("Instant of the deflection", "when the tool passes the beginning of the 20th interval."),
    ("State at the deflection", "the joints go on with the velocities and accelerations they were commanded; only the"
     " position is the measured one. The tip, on the deflected pose, may then be faster than the feed by a little;"
     " what no command can change fades over the way back."),
    ("Way back", "each joint a quintic of time to the motion at the rejoining; genetic by way of the paper's projection"
     " and the next reference point, optimal where the whole costs least."),
]  # fmt: skip
"""What the paper leaves open, and what was taken for it."""
