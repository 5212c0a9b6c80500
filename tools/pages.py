"""Tables of the pages from the results of the benchmarks: no figure of a result is typed twice.

    python tools/pages.py           writes each table anew, and the index of the results
    python tools/pages.py --check   names the pages that differ from the results, changes nothing, exits with 1

A page holds a table between `<!-- results: NAME -->` and `<!-- end of results -->`; NAME is a function of `TABLES`.
Each table ends with a line that says by what, when and where it was measured.
"""

from __future__ import annotations

import argparse
import datetime
import json
import re
import statistics
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

TOP = Path(__file__).parents[1]
RESULTS = TOP / "benchmarks" / "results"
REGION = re.compile(r"(<!-- results: ([\w-]+) -->\n).*?(<!-- end of results -->)", re.DOTALL)
NOT_NOTED = "not noted"
BUSY = 3.0
"""Load of a machine of two cores above which times are not those of a quiet one."""

Rows = list[list[str]]


def page(name: str) -> str:
    """The text of one page of results."""
    return (RESULTS / f"{name}.md").read_text(encoding="utf-8")


def rows(name: str, first_heads: str) -> Rows:
    """The body of the table of a page whose head line begins with `first_heads`, as words."""
    lines = page(name).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(first_heads))
    body: Rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        body.append([word.strip() for word in line.strip("|").split("|")])
    return body


def table(heads: list[str], body: Rows, words: int = 1) -> str:
    """A Markdown table whose first columns are words, the others figures."""
    rule = ["---"] * words + ["--:"] * (len(heads) - words)
    return "\n".join("| " + " | ".join(line) + " |" for line in [heads, rule, *body]) + "\n"


def measured(name: str) -> tuple[str, str, str]:
    """Command, date (year-month-day) and processor that a page of results names; `not noted` where it does not."""
    text = page(name)
    command = re.search(r"`((?:python -m|make) [^`]+)`", text)
    day = re.search(r"\d{4}-\d\d-\d\d", text) or re.search(r"\d{1,2} \w+ \d{4}", text)
    when = NOT_NOTED
    if day:
        form = "%Y-%m-%d" if "-" in day[0] else "%d %B %Y"
        when = datetime.datetime.strptime(day[0], form).date().isoformat()
    where = re.search(r"processor ([^,]+), cores (\d+)", text)
    known = f"{where[1]}, {where[2]} cores" if where else NOT_NOTED
    return (command[1] if command else NOT_NOTED), when, known


def source(name: str, at: str = "") -> str:
    """The line below a table: the page of results, the command, the day and the processor."""
    command, when, where = measured(name)
    on = f", {where}" if where != NOT_NOTED else ""
    load = re.search(r"Load of the machine at the end: (\d+\.\d)", page(name))
    on += f", under a load of {load[1]}" if load and float(load[1]) > BUSY else ""
    return f"\nMeasured on {when}{on}: `{command}`, [results]({at}{name}.md).\n"


def planner_rows() -> dict[tuple[str, str, int], dict[str, Any]]:
    """Every row of planner.json by case, planner and mesh cells."""
    found = json.loads((RESULTS / "planner.json").read_text(encoding="utf-8"))["rows"]
    return {(row["case"], row["planner"], row["n"]): row for row in found}


OURS, GUARDED = "toolpace", "toolpace, guarded"
PEERS = {
    OURS: "toolpace, limits at the nodes",
    GUARDED: "toolpace, limits everywhere (default)",
    "IPOPT": "IPOPT, same discretisation",
    "copp, one pass": "COPP, one pass",
    "copp, its loop": "COPP, its loop",
    "toppra": "toppra (no jerk limits)",
}


def peers(at: str) -> str:
    """Each planner on the 27 paths at 1000 cells: duration, time a point, highest use of a limit between nodes."""
    by = planner_rows()
    body = []
    for planner, name in PEERS.items():
        solved = [row for (_, who, n), row in by.items() if who == planner and n == 1000 and row["ok"]]
        ratios = [row["duration_s"] / by[row["case"], GUARDED, 1000]["duration_s"] for row in solved]
        time = [row["us_a_point"] for row in solved]
        use = max(row["usage_between"] for row in solved)
        between = "jerk unlimited" if planner == "toppra" else f"{use:.5f}"
        body.append([
            name, f"{statistics.median(ratios):.4f}", f"{max(ratios):.4f}",
            f"{statistics.median(time):.1f}", f"{max(time):.1f}", between,
        ])  # fmt: skip
    heads = ["27 paths, 1000 cells", "duration, median", "worst", "µs a point, median", "worst", "limit used, worst"]
    return table(heads, body) + source("planner", at)


def times(at: str) -> str:
    """Each peer's time a point over that of the core, by mesh, and how many paths it solved."""
    by = planner_rows()
    cases = list(dict.fromkeys(case for case, _, _ in by))
    body = []
    for planner in ("IPOPT", "copp, one pass", "toppra"):
        line = [PEERS[planner]]
        for n in (200, 1000, 5000):
            asked = [(by[case, planner, n], by[case, OURS, n]) for case in cases if (case, planner, n) in by]
            ratios = [theirs["us_a_point"] / ours["us_a_point"] for theirs, ours in asked]
            solved = sum(theirs["ok"] for theirs, _ in asked)
            line += [f"{statistics.median(ratios):.3g}", f"{min(ratios):.3g}", f"{solved} of {len(asked)}"]
        body.append(line)
    heads = ["time a point over toolpace's core"]
    heads += [f"{n} cells: {what}" for n in (200, 1000, 5000) for what in ("median", "least", "solved")]
    return table(heads, body) + source("planner", at)


def bound(at: str) -> str:
    """Gap between plan and lower bound on the default mesh: of the plan, after a proof, and on no mesh."""
    gap = next(line for line in rows("bound", "| guard | n |") if line[:2] == ["yes", "default"])
    proved = next(line for line in rows("bound", "| case | n | guard |") if line[:2] == ["all, worst after", "default"])
    summed = next(line for line in rows("bound", "| case | duration of the plan") if line[0] == "median, worst")
    body = [
        ["best plan on the same mesh, by the plan's own bound", gap[2], gap[3]],
        ["the same after `--prove`", "", proved[4]],
        ["every motion within the limits, on no mesh", *summed[3].split(", ")],
    ]
    return table(["at most this much faster [%]", "median", "worst"], body) + source("bound", at)


def long_paths(at: str) -> str:
    """A million points: time, memory, and the time a point beside that of ten thousand."""
    heads = ["1 000 000 points", "wall time [s]", "CPU [µs/point]", "over that at 10 000 points", "peak memory [MB]"]
    body = [
        [line[0], line[2], line[4], line[6], line[7]]
        for line in rows("scaling", "|  | points | total")
        if line[1] == "1000001"
    ]
    return table(heads, body) + source("scaling", at)


def second_order(at: str) -> str:
    """The planner without jerk limits beside COPP's."""
    found = {line[0]: line[1:] for line in rows("second-order", "| over all cases | n = 200")}
    named = {"off copp": "difference of the duration from COPP's, relative", "/ copp": "time a point over COPP's"}
    heads = ["over 27 paths", *(f"{n} cells, {what}" for n in (200, 1000, 5000) for what in ("median", "worst"))]
    body = [[name, *found[key][:6]] for key, name in named.items()]
    return table(heads, body) + source("second-order", at)


def replans(at: str) -> str:
    """Ways back after random deflections, by path and cause."""
    found = json.loads((RESULTS / "deflections.json").read_text(encoding="utf-8"))
    heads = ["path, cause", "replans", "refused", "limit used, worst", "over ruckig's time: median", "worst",
             "computing [ms]: median", "worst"]  # fmt: skip
    body = []
    for row in found["rows"]:
        over, took = row["over_shortest"], row["replan_ms"]
        body.append([
            f"{row['path']}, {row['cause']}", str(row["replans"]), str(len(row["refused"])),
            f"{row['used_by_positions']['worst']:.5f}", f"{over['median']:.2f}", f"{over['worst']:.1f}",
            f"{took['median']:.0f}", f"{took['worst']:.0f}",
        ])  # fmt: skip
    when, where = found.get("date") or f"{found['committed']} (committed)", found["machine"].split(", ")[1]
    said = f"Measured on {when}, {where}, seed {found['seed']}: `python -m benchmarks.deflections`, `deflections.json`."
    return table(heads, body) + f"\n{said}\n"


def efforts(at: str) -> str:
    """What each effort gives, without feeds but for what says so."""
    body = [line[:6] + line[7:] for line in rows("efforts", "| program | low [s] |")]
    heads = ["program", "`low` [s]", "`normal` [s]", "`high` [s]", "normal / low", "high / normal",
             "CPU [s]: low", "normal", "high"]  # fmt: skip
    return table(heads, body) + source("efforts", at)


def cluster(at: str) -> str:
    """The same programs one by one and on two workers."""
    heads = ["", "programs", "wall time", "jobs, summed up", "processors", "load", "client", "scheduler"]
    return table(heads, rows("cluster", "| | programs | wall time")) + source("cluster", at)


def linuxcnc(at: str) -> str:
    """LinuxCNC's own run of a program beside our plan, and the plan played by LinuxCNC."""
    heads = ["program", "LinuxCNC itself", "of a joint's velocity, acceleration", "plan", "played by LinuxCNC",
             "of velocity, acceleration"]  # fmt: skip
    body = [
        [line[0].rstrip(" *"), line[1], line[2], line[4], line[5].split(" (")[0], line[6]]
        for line in rows("linuxcnc_plans", "| program | LinuxCNC itself")
    ]
    return table(heads, body) + source("linuxcnc_plans", at)


def single(at: str) -> str:
    """Single figures of other pages, each with its page."""
    rounded = re.search(r"Worst of (\d+) programs: \*\*([\d.]+)\*\*", page("rounding"))
    assert rounded
    with_jerk = [float(line[3]) for line in rows("second-order", "| case | second order [s]")]
    used = max(float(word) for line in rows("followed", "| case | runs") for word in line[6:9])
    runs = sum(int(line[1]) for line in rows("followed", "| case | runs"))
    step = next(line for line in rows("following", "| set-points of the path | clock") if line[1] == "thread, one run")
    off = sorted((abs(float(line[5])) for line in rows("linuxcnc_times", "| program | whose")), reverse=True)
    nasty = rows("robustness", "| family | cases")
    usage = max(float(line[5]) for line in nasty)
    jerk = f"{statistics.median(with_jerk):.4g}, {max(with_jerk):.4g}"
    body = [
        ["time with jerk limits over time without, 27 paths, median and worst", jerk, "second-order"],
        [f"rounded programs over the exact curves, worst of {rounded[1]}", rounded[2], "rounding"],
        [f"largest utilisation in {nasty[-1][1]} nasty paths", f"{usage:.6f}", "robustness"],
        [f"largest utilisation in {runs} runs of the follower, random measurements", f"{used:.4f}", "followed"],
        ["a step of the follower's kernel, median [µs]", step[2], "following"],
        [f"`toolpace time` off LinuxCNC: {len(off)} programs, worst two [%]", f"{off[0]}, {off[1]}", "linuxcnc_times"],
    ]  # fmt: skip
    linked = [[what, figure, f"[{measured(name)[1]}]({at}{name}.md)"] for what, figure, name in body]
    return table(["what", "figure", "measured on"], linked)


def browser_pages(at: str) -> str:
    """What the pages of plans cost a browser without graphics."""
    heads = ["page", "motion", "size [MB]", "first picture [s]", "frames/s, 1 x", "longest frame [ms], 1 x",
             "frames/s, 10 x", "longest frame [ms], 10 x", "memory [MB]"]  # fmt: skip
    body = rows("pages", "| page | motion")
    kept = (0, 1, 2, 3, 4, 6, 8)
    return table([heads[k] for k in kept], [[line[k] for k in kept] for line in body], words=2) + source("pages", at)


def questions(at: str) -> str:
    """Three questions of a new user, with the seconds until they are answered."""
    heads = ["question", "answer", "clicks", "keys", "page loads", "waiting [s]", "hand and head [s]", "together [s]"]
    return table(heads, rows("questions", "| question | answer"), words=2) + source("questions", at)


def cut_feeds(at: str) -> str:
    """Times of public programs before and after new feeds, by three models of controls, and of the ideal motion."""
    first = "| program | feeds"
    heads = next(line for line in page("cut_feeds").splitlines() if line.startswith(first))
    return table([word.strip() for word in heads.strip("|").split("|")], rows("cut_feeds", first), words=2) + source(
        "cut_feeds", at
    )


def results(at: str) -> str:
    """Every page of results: its title, command, day and processor."""
    body = []
    for path in sorted(RESULTS.glob("*.md")):
        title = re.search(r"^#+ (.*)$", page(path.stem), re.MULTILINE)
        command, when, where = measured(path.stem)
        body.append([f"[{title[1] if title else path.stem}]({at}{path.stem}.md)", f"`{command}`", when, where])
    return table(["page", "command", "measured on", "processor"], body, words=4)


TABLES: dict[str, Callable[[str], str]] = {
    "peers": peers, "times": times, "bound": bound, "long-paths": long_paths, "second-order": second_order,
    "replans": replans, "efforts": efforts, "linuxcnc": linuxcnc,
    "cluster": cluster, "cut-feeds": cut_feeds, "single": single, "index": results, "pages": browser_pages,
    "questions": questions,
}  # fmt: skip


def written(path: Path) -> str:
    """The text of a page with its tables as the results have them."""
    up = "../" * len(path.relative_to(TOP).parents[:-1])
    at = f"{up}benchmarks/results/"
    text = path.read_text(encoding="utf-8")
    return REGION.sub(lambda found: f"{found[1]}{TABLES[found[2]](at)}{found[3]}", text)


def pages() -> list[Path]:
    """Every page that holds a table of results."""
    found = [TOP / "README.md", *sorted((TOP / "docs").rglob("*.md"))]
    return [path for path in found if "gallery" not in path.parts and REGION.search(path.read_text(encoding="utf-8"))]


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="name the pages that differ, and change nothing")
    check = parser.parse_args().check
    stale = {path: text for path in pages() if (text := written(path)) != path.read_text(encoding="utf-8")}
    for path, text in stale.items():
        print(f"{path.relative_to(TOP)} {'differs from the results: python tools/pages.py' if check else 'written'}")
        if not check:
            path.write_text(text, encoding="utf-8")
    sys.exit(1 if check and stale else 0)


if __name__ == "__main__":
    main()
