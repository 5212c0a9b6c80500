# ruff: noqa: RUF001 - dashes, minus signs and primes, as tables and formulas are set
"""The tables of the study: times, ways back, periods; misprints of the paper, each with a check; what was chosen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.kernels.motion import quintic
from toolpace.path.axis_path import AxisPath
from toolpace.study.simulation import CLOSED_FORM, DEFLECTION, FEED, OPTIONS, PRINTED_PROJECTION, SEEDS, Study, periods

WAYS = {
    "literal_acceleration": "to the letter",
    "literal_jerk": "to the letter, jerk too",
    "genetic": "genetic",
    "optimal": "optimal",
}
"""Columns of the table of ways."""
LENGTH, Z1, Z2 = 0.05, 0.3, 0.03
"""Tool length and structure, section III [m]."""


@dataclass(frozen=True)
class Table:
    """Words in rows."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: bool = False
    """Whether all but the first column are numbers."""


def times_table(study: Study) -> Table:
    """Totals and bounds, and what other seeds of the genetic algorithm find."""
    best = study.optimal.duration

    def against(seconds: float) -> str:
        return f"{100 * (seconds / best - 1):+.3f} %"

    rows = []
    for n, trajectory in study.genetic.items():
        found = study.by_seed[n]
        rows.append(
            (f"genetic, {n} generation{'s' if n > 1 else ''} of {OPTIONS.population}, seed {OPTIONS.seed}",
             f"{trajectory.duration:.5f}", against(trajectory.duration),
             f"{found.min():.4f} – {found.mean():.4f} – {found.max():.4f}", f"{trajectory.usage().worst:.5f}",
             f"{trajectory.solve_seconds:.2f} s")
        )  # fmt: skip
    rows += [
        (
            "optimal",
            f"{best:.5f}",
            "",
            "",
            f"{study.optimal.usage().worst:.5f}",
            f"{study.optimal.solve_seconds:.2f} s",
        ),
        ("optimum in closed form, to first order", f"{CLOSED_FORM:.4f}", against(CLOSED_FORM), "", "", ""),
    ]  # fmt: skip
    if study.optimal.lower_bound > 0.0:
        bound = study.optimal.lower_bound
        rows.append(("lower bound on this mesh, all limits", f"{bound:.5f}", against(bound), "", "", ""))
    rows.append(("lower bound, feed alone", f"{study.feed_bound:.5f}", against(study.feed_bound), "", "", ""))
    for name, (before, after) in study.pairs().items():
        spent = study.instant[name] + after.duration
        rows.append(
            (f"{name}, with deflection at {study.instant[name]:.3f} s", f"{spent:.5f}",
             f"{1e3 * (spent - before.duration):+.0f} ms by it", "", f"{after.usage().worst:.5f}",
             f"{after.solve_seconds:.2f} s")
        )  # fmt: skip
    spread = f"seeds {SEEDS[0]} to {SEEDS[-1]}: least – mean – most"
    return Table(("", "total [s]", "against optimal", spread, "peak use", "computed in"), tuple(rows), numeric=True)


def ways_table(study: Study) -> Table:
    """The way back, by the paper's step (2) to the letter in both readings, and ours."""
    linear = [j for j, rotary in enumerate(study.machine.is_rotary) if not rotary]
    jumps, back, remaining = jumps_of(study), study.backwards(), study.remaining()

    def row(name: str, words: dict[str, str]) -> tuple[str, ...]:
        return (name, *(words[way] for way in WAYS))

    def at_once(jump: Floats) -> str:
        return f"{1e3 * np.abs(jump[linear]).max():.3f}"

    letter = ("literal_acceleration", "literal_jerk")
    own = dict.fromkeys(("genetic", "optimal"), "as the joints move, then as the reference does")
    jerks = {
        f"literal_{name}": " and ".join(f"{x:.3f}" for x in np.linalg.norm(way.rates[2, :, :3], axis=1))
        for name, way in study.literal.items()
    }
    peaks = {f"literal_{name}": way.trajectory for name, way in study.literal.items()} | study.with_deflection
    turned = {name: np.degrees(gone.joints[study.machine.joints.index("B")]) for name, gone in back.items()}
    rows = (
        row("A quintic of time each", dict.fromkeys(letter, "x_w, y_w, z_w, A, B") | dict.fromkeys(own, "all joints")),
        row("At its ends", dict(zip(letter, ("same velocity and acceleration",
            "same velocity, acceleration (zero) and jerk"))) | own),
        row("Back onto the path, T_dp [s]", {name: f"{duration:.4f}" for name, (_, duration) in study.ways().items()}),
        row("From the deflection to the end [s]", {name: f"{seconds:.4f}" for name, seconds in remaining.items()}),
        row("Peak use of a limit, but for what is asked at once",
            {name: f"{way.usage().worst:.5f}" for name, way in peaks.items()}),
        row("Jerk of the tip at both ends [m/s³]", jerks | dict.fromkeys(own, "")),
        row("Asked of a linear motor at once [mm/s]", {name: at_once(jump[0]) for name, jump in jumps.items()}),
        row("Asked of a linear motor at once [mm/s²]", {name: at_once(jump[1]) for name, jump in jumps.items()}),
        row("Gone back along the arc [mm]", {name: f"{1e3 * gone.tip:.3f}" for name, gone in back.items()}),
        row("B turned back [deg]", {name: f"{angle:.3f}" for name, angle in turned.items()}),
    )  # fmt: skip
    return Table(("", *WAYS.values()), rows)


def jumps_of(study: Study) -> dict[str, Floats]:
    """(2, m) velocity and acceleration that the joints would have to take on at once, by way back."""
    out = {f"literal_{name}": way.jump for name, way in study.literal.items()}
    for name, (before, after) in study.pairs().items():
        old, new = before.at(np.array([study.instant[name]])), after.at(np.zeros(1))
        out[name] = np.stack([new.qd[0] - old.qd[0], new.qdd[0] - old.qdd[0]])
    return out


def reversal(study: Study) -> str:
    """What of the ways back goes backwards, in words."""
    b, ways = study.machine.joints.index("B"), study.backwards()

    def gone(name: str) -> str:
        return f"{1e3 * ways[name].tip:.2f} mm along the arc, and B {np.degrees(ways[name].joints[b]):.2f}°"

    return (
        "Only the neighbourhood of the deflection is drawn; positions count from where the joints were commanded to be."
        " By way of the projection A and B turn back and go on again: at both ends they have the same velocity, but"
        " hardly any way to go between, and no quintic can then but reverse. The genetic way goes back"
        f" {gone('genetic')}; to the letter it is {gone('literal_acceleration')}; the optimal way {gone('optimal')}."
    )


def comparison(study: Study) -> Table:
    """Quantity, as printed, ours."""
    peaks = {name: (a.usage().worst, b.usage().worst) for name, (a, b) in study.pairs().items()}

    def triple(values: tuple[float, ...] | Floats, digits: int) -> str:
        return f"({', '.join(f'{v:.{digits}g}' for v in values)}) m"

    length = float(study.points[-1])
    rows = (
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
    )  # fmt: skip
    return Table(("", "printed", "ours"), rows)


def periods_table(study: Study) -> Table:
    """T_i by planner."""
    columns = {f"genetic, {n}": periods(study, t) for n, t in study.genetic.items()}
    columns["optimal"] = periods(study, study.optimal)
    count = len(study.points) - 1
    rows = [(str(k + 1), *(f"{v[k]:.5f}" for v in columns.values())) for k in range(count)]
    rows.append(("sum", *(f"{v.sum():.5f}" for v in columns.values())))
    return Table(("interval", *columns), tuple(rows), numeric=True)


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
