"""The tables of a sweep: what its rows come to."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table

KINDS = ("feed", "velocity", "acceleration", "jerk")
NAMED = 60
"""Most rows of each list."""
PROMISED = 1.0001
FAR = 0.02
FEW = 300
"""Points of a mesh up to which a plan costs about the same, however few they are: a round of it takes milliseconds."""
ASKING = 0.5
"""Share of a plan's time from which its cost is that of the path."""
Row = dict[str, Any]


def cause(row: Row, cost: float, slow: float, few: float) -> str:
    """Why a plan takes more than `slow` for each of its points; "" where it does not, or nobody knows.

    `cost`: what it takes [s a point]; `few`: three times what a plan on few points takes in all, in the median [s].
    """
    if cost <= slow:
        return ""
    if row["points"] <= FEW and row["cpu"] <= few:
        return f"few points: {row['cpu'] * 1e3:.0f} ms in all"
    own = row.get("path_cpu", 0.0)
    if own > ASKING * row["cpu"] or row["cpu"] - own <= slow * row["points"]:
        return f"the path: {own / row['points'] * 1e6:.0f} microseconds a point"
    return "; ".join(row.get("notes", []))


def write_tables(rows: list[Row], command: str, slow: float) -> None:
    """Write benchmarks/results/sweep.md and sweep.json, and print the tables."""
    planned = [row for row in rows if "usage" in row]
    if not planned:
        print("nothing is there yet")
        return
    cost = np.array([row["cpu"] / max(row["points"], 1) for row in planned]) * 1e6
    limit = slow * float(np.median(cost)) * 1e-6
    small = [row["cpu"] for row in planned if row["points"] <= FEW]
    few = slow * float(np.median(small)) if small else 0.0
    causes = [cause(row, each * 1e-6, limit, few) for row, each in zip(planned, cost)]
    unsaid = [each > limit * 1e6 and not said for each, said in zip(cost, causes)]
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
            f" {said or 'without a stated cause'}"
            for each, row, said in sorted(zip(cost, planned, causes), key=lambda three: (bool(three[2]), -three[0]))
            if each > slow * np.median(cost)
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
        "slow": int((cost > slow * np.median(cost)).sum()),
        "slow without a stated cause": sum(unsaid),
        "by default with a gap above 2 percent": len(lists[f"Gap above {FAR:.0%}, by default"]),
    }  # fmt: skip
    print(json.dumps(figures, indent=1))
    text = f"# Random plans, judged from positions alone\n\n{written_by(command)}\n\n"
    text += "".join(f"* {key}: {value}\n" for key, value in figures.items()) + "\n"
    text += "\n".join(each.markdown() for each in tables)
    for head, lines in lists.items():
        text += f"\n## {head}: {len(lines)}\n\n" + "".join(f"* {line}\n" for line in lines[:NAMED])
        text += f"* and {len(lines) - NAMED} more\n" if len(lines) > NAMED else ""
    (RESULTS / "sweep.md").write_text(text)
    slowest = Counter(row["family"] for each, row in zip(cost, planned) if each > slow * np.median(cost))
    (RESULTS / "sweep.json").write_text(json.dumps(figures | {"slow by family": dict(slowest)}, indent=1) + "\n")


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
