"""The rows of a run as tables: for the terminal with rich, for the repository as Markdown."""

from __future__ import annotations

import statistics
from dataclasses import dataclass, field

Row = dict[str, object]
MOST_RATIO = 1.0001
MOST_OF_TOPPRA = 0.8
LEAST_AHEAD = {("copp, one pass", 1000): 25.0, ("IPOPT", 1000): 25.0, ("copp, one pass", 5000): 60.0}
"""How many times the time a point of ours a peer should take at least."""
MOST_USAGE = 1.0001


@dataclass
class Table:
    """A title, column heads and lines of text; the first columns are words, the others numbers."""

    title: str
    heads: list[str]
    lines: list[list[str]] = field(default_factory=list)
    words: int = 1

    def markdown(self) -> str:
        """The table as Markdown."""
        rule = ["---"] * self.words + ["--:"] * (len(self.heads) - self.words)
        body = ["| " + " | ".join(line) + " |" for line in [self.heads, rule, *self.lines]]
        return f"## {self.title}\n\n" + "\n".join(body) + "\n"

    def show(self) -> None:
        """Print it."""
        from rich.console import Console
        from rich.table import Table as RichTable

        table = RichTable(title=self.title, title_justify="left")
        for i, head in enumerate(self.heads):
            table.add_column(head, justify="left" if i < self.words else "right", no_wrap=True)
        for line in self.lines:
            table.add_row(*line)
        Console(width=150).print(table)


class Results:
    """Rows by case, mesh and planner."""

    def __init__(self, rows: list[Row]) -> None:
        self.by = {(r["case"], r["n"], r["planner"]): r for r in rows}
        self.cases = list(dict.fromkeys(str(r["case"]) for r in rows))
        self.meshes = sorted({int(str(r["n"])) for r in rows})
        self.planners = list(dict.fromkeys(str(r["planner"]) for r in rows))

    def get(self, case: str, n: int, planner: str, key: str) -> float | None:
        """One figure; None where there is none."""
        row = self.by.get((case, n, planner))
        value = row[key] if row and (row["ok"] or key == "us_a_point") else None
        return float(str(value)) if value is not None else None

    def ratio(self, case: str, n: int, a: tuple[str, str], b: tuple[str, str]) -> float | None:
        """Quotient of two figures, each by planner and key."""
        top, bottom = self.get(case, n, *a), self.get(case, n, *b)
        return top / bottom if top is not None and bottom else None


def text(value: float | None, form: str = ".4f", most: float = float("inf")) -> str:
    """A number, with a mark where it misses its target."""
    if value is None:
        return "failed"
    return format(value, form) + (" !" if value > most else "")


OURS, GUARDED = "toolpace", "toolpace, guarded"
BEST = ((OURS, "objective_s"), ("IPOPT", "objective_s"))
SPEED = ((OURS, "us_a_point"), ("toppra", "us_a_point"))


def targets(results: Results) -> Table:
    """Optimum, speed and guarantee, case by case."""
    heads = [
        "case", "n", "duration [s]", "IPOPT [s]", "time / IPOPT's", "us/point", "toppra us/point", "/ toppra",
        "guarded [s]", "usage between", "guarded us/point",
    ]  # fmt: skip
    table = Table("Optimum, speed and guarantee (! misses its target)", heads)
    for case in results.cases:
        for n in results.meshes:
            if (case, n, OURS) not in results.by:
                continue
            table.lines.append(
                [
                    case,
                    str(n),
                    text(results.get(case, n, OURS, "duration_s")),
                    text(results.get(case, n, "IPOPT", "duration_s")),
                    text(results.ratio(case, n, *BEST), ".7f", MOST_RATIO),
                    text(results.get(case, n, OURS, "us_a_point"), ".1f"),
                    text(results.get(case, n, "toppra", "us_a_point"), ".1f"),
                    text(results.ratio(case, n, *SPEED), ".2f", MOST_OF_TOPPRA if n == 1000 else float("inf")),
                    text(results.get(case, n, GUARDED, "duration_s")),
                    text(results.get(case, n, GUARDED, "usage_between"), ".5f", MOST_USAGE),
                    text(results.get(case, n, GUARDED, "us_a_point"), ".0f"),
                ]
            )
    return table


def summary(results: Results) -> Table:
    """Median and worst of the same over all cases."""
    heads = ["over all cases", *(f"n = {n}, {what}" for n in results.meshes for what in ("median", "worst"))]
    table = Table(f"Summary of {len(results.cases)} cases", heads)
    kinds = (
        ("time / IPOPT's, same discretisation", ".7f", lambda c, n: results.ratio(c, n, *BEST)),
        ("us/point", ".1f", lambda c, n: results.get(c, n, OURS, "us_a_point")),
        ("time a point / toppra's", ".2f", lambda c, n: results.ratio(c, n, *SPEED)),
        ("usage between nodes, not guarded", ".4f", lambda c, n: results.get(c, n, OURS, "usage_between")),
        ("usage between nodes, guarded", ".5f", lambda c, n: results.get(c, n, GUARDED, "usage_between")),
        ("time lost to the guard", ".5f",
         lambda c, n: results.ratio(c, n, (GUARDED, "duration_s"), (OURS, "duration_s"))),
    )  # fmt: skip
    for name, form, figure in kinds:
        line = [name]
        for n in results.meshes:
            values = [v for c in results.cases if (v := figure(c, n)) is not None]
            line += [text(statistics.median(values), form), text(max(values), form)] if values else ["-", "-"]
        table.lines.append(line)
    for planner in ("copp, one pass", "IPOPT", "linear program"):
        line = [f"{planner}: time a point / ours (worst: least)"]
        for n in results.meshes:
            values = [v for c in results.cases if (v := results.ratio(c, n, (planner, SPEED[0][1]), SPEED[0]))]
            short = " !" if values and min(values) < LEAST_AHEAD.get((planner, n), 0.0) else ""
            line += [f"{statistics.median(values):.0f}", f"{min(values):.0f}{short}"] if values else ["-", "-"]
        table.lines.append(line)
    for planner in (OURS, GUARDED, "IPOPT"):
        line = [f"{planner}: cases solved"]
        for n in results.meshes:
            asked = [results.by[c, n, planner] for c in results.cases if (c, n, planner) in results.by]
            line += [f"{sum(bool(row['ok']) for row in asked)} of {len(asked)}", ""]
        table.lines.append(line)
    return table


def peers(results: Results) -> Table:
    """Each peer against us: time, speed, limits; medians and worst cases over all paths it was asked."""
    heads = ["planner", "n", "asked", "solved", "duration / ours, median", "worst", "us/point, median", "worst",
             "usage between, worst"]  # fmt: skip
    table = Table("Peers (duration against ours with the guard, on the same n)", heads)
    for planner in results.planners:
        for n in results.meshes:
            asked = [c for c in results.cases if (c, n, planner) in results.by]
            if not asked:
                continue
            solved = sum(bool(results.by[c, n, planner]["ok"]) for c in asked)
            ratios = [r for c in asked if (r := results.ratio(c, n, (planner, "duration_s"), (GUARDED, "duration_s")))]
            speed = [v for c in asked if (v := results.get(c, n, planner, "us_a_point")) is not None]
            use = [v for c in asked if (v := results.get(c, n, planner, "usage_between")) is not None]
            table.lines.append(
                [
                    planner,
                    str(n),
                    str(len(asked)),
                    str(solved),
                    text(statistics.median(ratios), ".4f") if ratios else "-",
                    text(max(ratios), ".4f") if ratios else "-",
                    text(statistics.median(speed), ".1f") if speed else "-",
                    text(max(speed), ".1f") if speed else "-",
                    text(max(use), ".4f") if use else "-",
                ]
            )
    return table


def published(results: Results, names: list[str]) -> Table:
    """Every planner on the published paths."""
    heads = ["path", "planner", *(f"n = {n}: {what}" for n in results.meshes for what in ("s", "us/point", "usage"))]
    table = Table("Published paths, every planner (usage: worst between nodes; toppra: without jerk)", heads, words=2)
    for case in names:
        for planner in results.planners:
            line = [case, planner]
            for n in results.meshes:
                if (case, n, planner) not in results.by:
                    line += ["-", "-", "-"]
                    continue
                between = results.get(case, n, planner, "usage_between")
                line += [
                    text(results.get(case, n, planner, "duration_s")),
                    text(results.get(case, n, planner, "us_a_point"), ".1f"),
                    text(between, ".4f") if between is not None else "-",
                ]
            table.lines.append(line)
    return table


def memory(peaks: dict[tuple[str, int], tuple[float, float]], case: str) -> Table:
    """Most memory of a process that plans a case, by planner and n; in brackets beyond what was loaded before."""
    meshes = sorted({n for _, n in peaks})
    table = Table(
        f"Most memory of a process that plans {case} [MB] (beyond what its libraries and code take)",
        ["planner", *(f"n = {n}" for n in meshes)],
    )
    for planner in dict.fromkeys(name for name, _ in peaks):
        found = [peaks.get((planner, n)) for n in meshes]
        table.lines.append([planner, *(f"{one[0]:.0f} ({one[0] - one[1]:.0f})" if one else "failed" for one in found)])
    return table


def failures(rows: list[Row]) -> Table:
    """Every planner that gave up, and its words."""
    table = Table("Failures", ["case", "n", "planner", "what it said"], words=4)
    for r in rows:
        if not r["ok"]:
            table.lines.append([str(r["case"]), str(r["n"]), str(r["planner"]), str(r["note"])])
    return table
