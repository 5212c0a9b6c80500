# ruff: noqa: RUF001 - minus signs and primes, as formulas are set
"""Misprinted equations of the paper, each with the correct form and its check."""

from __future__ import annotations

import numpy as np

from toolpace.kernels.motion import quintic
from toolpace.path.axis_path import AxisPath
from toolpace.study.simulation import PRINTED_PROJECTION, Study
from toolpace.study.tables import Table

LENGTH, Z1, Z2 = 0.05, 0.3, 0.03
"""Tool length and structure, section III [m]."""


def all_errata(study: Study) -> Table:
    """All lines, in the order of the paper: where, printed, holds, check."""
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
    rows = (
        ("II.B, point P_t", "(0, 0, l_t, 1)", "(0, 0, −l_t, 1)",
                f"only so does Eq. (1) give Eq. (2); as printed it is off by up to {1e3 * wrong:.0f} mm"),
        ("Eq. (1), (2)", "tip in the lower-ground frame", "right as printed",
                "Eq. (2) follows from Eq. (1) with the point above"),
        ("Eq. (3) to (5)", "forward kinematics", "right as printed",
                f"the machine paper-ab agrees along the arc to {np.abs(forward - tip).max():.1e} m"),
        ("Eq. (6), third line", "z_gt = … + l_t sin A − z₁", "z_gt = … + l_t cos A − z₁",
                f"as printed off by up to {1e3 * np.abs(printed_z - z).max():.1f} mm; put right, by"
                f" {np.abs(right_z - z).max():.1e} m"),
        ("Eq. (7b), D₃", "r(k+1)″ − 2 C₂", "(r(k+1)″ − 2 C₂) / 2",
                f"as printed the second derivative at the end of interval 1 is {1e6 * (2 * end - start):.4f} µm"
                f" instead of {1e6 * end:.4f} µm (x, by u)"),
        ("Eq. (7d)", "o(T_i), and [z_w(i)]′ for [z_w(i)′]", "o(T_i²); a misprint",
                "Taylor's remainder after the square; the next term is of third order"),
        ("Eq. (7e)", "J = w‴u̇³ + 3 w″u̇ü", "+ w′ d³u/dt³",
                f"at the start of the optimal motion the printed terms give {printed_jerk:.3g}, all three {full:.4g}"
                " m/s³ or rad/s³"),
        ("III, the circle", "centre (0.0707, 0.0707, 0), radius 0.1 m", "centre at the origin, plane x = y",
                f"the printed projection is {np.linalg.norm(projection):.5f} m from the origin and"
                f" {np.linalg.norm(projection - centre):.4f} m from the printed centre"),
        ("III, “20th interval”", "projection (0.058, 0.058, 0.0571)",
                f"({', '.join(f'{v:.5f}' for v in ours.tip)}), the first point of the 20th of 31 intervals",
                f"{1e3 * ours.distance:.3f} mm away; u clipped to [0, 1]; every printed digit is met"),
        ("III, the projection", "called the projection on the curve",
                f"({', '.join(f'{v:.5f}' for v in whole.tip)}), in the 19th interval",
                f"{1e3 * whole.distance:.3f} mm away, against {1e3 * ours.distance:.3f} mm of the printed point"),
    )  # fmt: skip
    return Table(("where", "printed", "holds", "check"), rows)


CHOICES = Table(
    ("", "chosen"),
    (
        ("Tool axis",
         "a constant lead angle to the tangent in the plane of the curve, 45° off the outward normal, so it"
         " turns from −45° to +45°. The tangent itself and the normal are impossible: tan B and sec B are"
         " infinite there. A stays within ±30°, B within ±35.3°."),
        ("Parameter of the curve",
         "the length of the arc; derivatives at the reference points are the exact ones of arc and angles, and"
         " between them each coordinate is the quintic of Eq. (7a, 7b)."),
        ("Rotary joints between reference points",
         "quintics of A and B, as Eq. (7a) has them; the tool axis follows from them, so that between the"
         " points it leaves the chosen lead angle by less than 1e-10 rad."),
        ("Velocity, acceleration and jerk of the motors",
         "exact derivatives of Eq. (6) along the interval, where the paper interpolates those of the rotary"
         " motors with their known position."),
        ("Time within an interval",
         "the parameter runs as the quintic of t / T_i that has the preset speed and acceleration at both"
         " reference points. The paper steps from point to point by Taylor's series to the second order, Eq."
         " (7d); that meets the next point, but not its speed and acceleration, and its rest is as large as the"
         " jerk."),
        ("Speeds are of the parameter",
         "du/dt and d²u/dt² are what is set at the points; with the length of the arc as the parameter du/dt"
         " is the feed rate, but for the error of the quintics."),
        ("Preset speeds",
         "98 percent of what jerk-limited ramps and the limits at each reference point allow, from rest to"
         " rest, lowered where an interval has no law within the limits."),
        ("Hills of preset speeds",
         "single speeds, then hills of up to fifteen neighbours (highest in the middle, falling evenly to both"
         " sides), are raised by 12, 6, 3 and 1.5 percent as long as every interval keeps a law within 98"
         " percent of the limits: lowering alone ends far above the optimum where the path is uneven."),
        ("Preset accelerations",
         "half the slope of the squared speeds by a monotone interpolant (the weighted harmonic mean of both"
         " chords), so that speeds do not overshoot; zero where the chords differ in sign."),
        ("Both ends of the curve",
         "rest: speed and acceleration zero, the third derivative positive on leaving."),
        ("Genetic algorithm",
         "one gene a period, 15 bits, population 20, tournaments of two, one-point crossover (0.8), 2 percent"
         " of the bits flipped, the best lives on, seed 2009. The first population holds one comfortable"
         " period; the others are random between 0.7 and 1.6 times that of the mean speed."),
        ("“One generation”",
         "a population is bred once from the random one; a child that breaks a limit counts a thousand periods"
         " and more, by how far it does. Each interval has a stream of random numbers of its own."),
        ("Periods held to the limits",
         "at 33 points of every interval, checked at 65 on both sides of each reference point, and tightened"
         " where a limit is exceeded between."),
        ("What is minimised",
         "each T_i by itself, which is the sum of Eq. T = ΣT_i as well, for the speeds at the points are set"
         " and the intervals do not touch each other."),
        ("Instant of the deflection",
         "when the tool passes the beginning of the 20th interval."),
        ("What the deflection displaces",
         "the joints; see “What a measured tip means”. The tool axis is the commanded one: the paper gives a"
         " position only."),
        ("Projection",
         "the nearest point, by bounds that miss none; the potential field of Eq. (8) to (10) is there as the"
         " alternative. Its target moves by the force along the path over the stiffness of the field, and"
         " starts at the nearest of 400 samples; the paper names neither."),
        ("State at the deflection",
         "the joints go on with the velocities and accelerations they were commanded; only the position is the"
         " measured one. The tip, on the deflected pose, may then be faster than the feed by a little; what no"
         " command can change fades over the way back."),
        ("Way back",
         "each joint a quintic of time to the motion at the rejoining; genetic by way of the paper's"
         " projection and the next reference point, optimal where the whole costs least."),
        ("Way back to the letter",
         "u of the first new interval is t / T_dp, since the paper does not say what u is there; the rotary"
         " joints at the deflection are those at the projection; population, bits and seed as above, the first"
         " population between a known period and half of it."),
        ("After the next reference point",
         "the motion goes on as it was known."),
    ),
)  # fmt: skip
"""What the paper leaves open, and what was taken for it."""
