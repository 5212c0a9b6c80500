# ruff: noqa: RUF001 - dashes and signs, as tables are set
"""The tables of the study."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolpace.common.arrays import Floats
from toolpace.study.simulation import CLOSED_FORM, DEFLECTION, FEED, OPTIONS, SEEDS, Study, periods

WAYS = {
    "literal_acceleration": "to the letter",
    "literal_jerk": "to the letter, jerk too",
    "genetic": "genetic",
    "optimal": "optimal",
}
"""Columns of the table of ways."""


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
