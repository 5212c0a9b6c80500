"""The tables of a sweep: what its rows come to."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.slow_plans import FEW, Row, cause, cause_by_planning_again

KINDS = ("feed", "velocity", "acceleration", "jerk")
NAMED = 60
"""Most rows of each list."""
PROMISED = 1.0001
FAR = 0.02
UNKNOWN = "without a stated cause"


def causes_of(
    planned: list[Row], limit: float, few: float, once_more: Callable[[Sequence[int]], dict[int, Row]]
) -> list[str]:
    """Why each plan takes more than `limit` a point; "" for those that do not."""
    causes = [cause(row, limit, few) for row in planned]
    unknown = [k for k, row in enumerate(planned) if row["cpu"] > limit * row["points"] and not causes[k]]
    again = once_more([planned[k]["seed"] for k in unknown])
    for k in unknown:
        second = again.get(planned[k]["seed"])
        causes[k] = cause_by_planning_again(planned[k], second, limit, few) if second else UNKNOWN
    return causes


def write_tables(
    rows: list[Row], command: str, slow: float, once_more: Callable[[Sequence[int]], dict[int, Row]]
) -> None:
    """Write benchmarks/results/sweep.md and sweep.json, and print the tables.

    A plan is slow from `slow` times the median cost a point on; `once_more` makes the rows of some seeds again.
    """
    planned = [row for row in rows if "usage" in row]
    if not planned:
        print("nothing is there yet")
        return
    cost = np.array([row["cpu"] / max(row["points"], 1) for row in planned]) * 1e6
    limit = slow * float(np.median(cost)) * 1e-6
    small = [row["cpu"] for row in planned if row["points"] <= FEW]
    few = slow * float(np.median(small)) if small else 0.0
    causes = causes_of(planned, limit, few, once_more)
    is_slow = [each > limit * 1e6 for each in cost]
    tables = [
        table("By family", rows, lambda row: row["family"]),
        table("By way: by default, on a fixed mesh, in motion at one end or both", rows, lambda row: row["way"]),
    ]
    lists = {
        f"Usage above {PROMISED}": [
            f"seed {row['seed']} ({row['family']}, {row['way']}, mesh {row['mesh']}): {max(row['usage']):.6f} by"
            f" positions, {row['told']:.6f} told"
            for row in planned
            if max(row["usage"]) > PROMISED
        ],
        "Wrong": [
            f"seed {row['seed']} ({row['family']}, {row['way']}): {row['wrong']}" for row in rows if "wrong" in row
        ],
        "Refused": [
            f"seed {row['seed']} ({row['family']}, {row['way']}, mesh {row.get('mesh')}): {row['refused']}"
            for row in rows
            if "refused" in row
        ],
        f"More than {slow:g} times the median CPU time a point ({np.median(cost):.0f} microseconds)": [
            f"seed {row['seed']} ({row['family']}, {row['way']}, mesh {row['mesh']}, {row['joints']} joints):"
            f" {each:.0f} microseconds for each of {row['points']} points, gap {row['gap'] or 0.0:.2g};"
            f" {said}"
            for each, row, said in sorted(zip(cost, planned, causes), key=lambda three: -three[0])
            if said
        ],
        f"Gap above {FAR:.0%}, by default": [
            f"seed {row['seed']} ({row['family']}): {'; '.join(row.get('notes', []))}"
            for row in sorted(planned, key=lambda row: -(row["gap"] or 0.0))
            if row["way"] == "default" and (row["gap"] or 0.0) > FAR
        ],
    }
    for each in tables:
        each.show()
    figures = {
        "plans": len(rows),
        "worst usage by positions": {k: max(row["usage"][i] for row in planned) for i, k in enumerate(KINDS)},
        "refused": len(lists["Refused"]),
        "wrong": len(lists["Wrong"]),
        "CPU microseconds a point": {
            "median": float(np.median(cost)), "99 percent": float(np.quantile(cost, 0.99)), "worst": float(cost.max()),
        },
        "slow": int(sum(is_slow)),
        "slow by cause": dict(Counter(said.split(":")[0] for said in causes if said).most_common()),
        "slow without a stated cause": causes.count(UNKNOWN),
        "by default with a gap above 2 percent": len(lists[f"Gap above {FAR:.0%}, by default"]),
        "gap above 2 percent without a word about it": sum(
            (row["gap"] or 0.0) > FAR and not row.get("notes") for row in planned
        ),
    }  # fmt: skip
    print(json.dumps(figures, indent=1))
    text = f"# Random plans, judged from positions alone\n\n{written_by(command)}\n\n"
    text += "".join(f"* {key}: {in_words(value)}\n" for key, value in figures.items()) + "\n"
    text += "\n".join(each.markdown() for each in tables)
    for head, lines in lists.items():
        text += f"\n## {head}: {len(lines)}\n\n" + "".join(f"* {line}\n" for line in lines[:NAMED])
        text += f"* and {len(lines) - NAMED} more\n" if len(lines) > NAMED else ""
    (RESULTS / "sweep.md").write_text(text)
    slowest = Counter(row["family"] for row, said in zip(planned, causes) if said)
    (RESULTS / "sweep.json").write_text(json.dumps(figures | {"slow by family": dict(slowest)}, indent=1) + "\n")


def in_words(value: object) -> str:
    """A figure with seven digits, or those of a table one after the other: "feed 1.000068, velocity 1.00007"."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {in_words(each)}" for key, each in value.items())
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def table(title: str, rows: list[Row], of: Callable[[Row], str]) -> Table:
    """A line for each family, or for each way."""
    heads = ["", "plans", "refused", "wrong", *(f"{kind}, worst" for kind in KINDS), "gap, median", "worst",
             "CPU a point, median [us]", "99 %", "worst"]  # fmt: skip
    found = Table(title, heads)
    for name in [*sorted({of(row) for row in rows}), "all"]:
        mine = [row for row in rows if name in (of(row), "all")]
        planned = [row for row in mine if "usage" in row]
        if not planned:
            continue
        cost = np.array([row["cpu"] / max(row["points"], 1) for row in planned]) * 1e6
        gaps = [row["gap"] for row in planned if row["gap"] is not None] or [0.0]
        found.lines.append([
            name, str(len(mine)), str(sum("refused" in row for row in mine)), str(sum("wrong" in row for row in mine)),
            *(f"{max(row['usage'][k] for row in planned):.6f}" for k in range(4)), f"{np.median(gaps):.1e}",
            f"{max(gaps):.1e}", f"{np.median(cost):.0f}", f"{np.quantile(cost, 0.99):.0f}", f"{cost.max():.0f}",
        ])  # fmt: skip
    return found
