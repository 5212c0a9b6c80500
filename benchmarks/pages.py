"""What the pages of plans cost a browser: size, time to the first picture, frames a second, memory.

    python -m benchmarks.pages [--case NAME]... [--out FILE]

Three motions, each with its stock: the demo, 25 operations in tilted planes, and a long program at a low feed. Each is
planned within 10 and within 5 µm; measured are the report of the first plan and the page that compares both, in
Chromium as it is on a computer without graphics (3-D by SwiftShader), 1400 x 1000 pixels, a browser of its own for each
page. Memory is that of all of its processes, what they share counted by share (PSS). Writes pages.md.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.first_minutes import LONG_BLOCKS, LONG_FEED
from benchmarks.machine import RESULTS, written_by
from benchmarks.tables import Table
from testbed.positioned import positioned
from testbed.programs import waves
from toolpace.cli.demo_programs import impeller_program
from toolpace.common.units import format_time
from toolpace.programs.reading.setup_file import load_setup
from toolpace.results.compare.motions import PlannedMotion
from toolpace.results.report import write_report
from toolpace.results.write import read_plan

COMMAND = [sys.executable, "-m", "toolpace"]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
GRAPHICS = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]
WINDOW = {"width": 1400, "height": 1000}
PLAYED = 3.0
"""Time for which frames are counted [s]."""
RATES = ("1", "10")
"""How many times faster than it is a motion is played meanwhile."""
TOOL = '[tools.{0}]\nkind = "{1}"\ndiameter = {2}\nteeth = 2\nflute_length = 40\n'
FIRST_PICTURE = """new Promise((done) => {
  const drawn = () => requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now())));
  const wait = () => (window.toolpaceReady ? drawn() : setTimeout(wait, 5));
  wait();
})"""
FRAMES = """(seconds) => new Promise((done) => {
  const begin = performance.now();
  let frames = 0, last = begin, longest = 0;
  const frame = () => {
    const now = performance.now();
    frames += 1; longest = Math.max(longest, now - last); last = now;
    if (now - begin < 1e3 * seconds) { requestAnimationFrame(frame); return; }
    toolpace.pause();
    done([(1e3 * frames) / (now - begin), longest]);
  };
  toolpace.play();
  requestAnimationFrame(frame);
})"""


class Case(NamedTuple):
    """A program, the sheet of its stock and tools, and what the command is told of it."""

    program: str
    sheet: str
    words: list[str]


def cases() -> dict[str, Case]:
    """By name."""
    rough = "".join(TOOL.format(number, "flat", 8) for number in range(1, 5))
    return {
        "demo": Case(
            impeller_program(),
            TOOL.format(1, "ball", 4)
            + "[stock]\ncylinder = { diameter = 62, from = [0, 0, -10], to = [0, 0, 26] }\n",
            ["-m", "xyzac-trunnion"],
        ),
        "25 operations": Case(
            positioned(blocks=141), rough + "[stock]\nbox = [[-32, -26, -20], [32, 26, 1]]\n",
            ["-m", "xyzbc-trunnion", "--controller", "fanuc"],
        ),
        "long": Case(
            waves(LONG_BLOCKS).replace("F3000", f"F{LONG_FEED}"),
            TOOL.format(1, "ball", 6) + "[stock]\nbox = [[-64, -44, -40], [64, 44, -13]]\n",
            ["-m", "xyzac-trunnion"],
        ),
    }  # fmt: skip


def planned(case: Case, place: Path) -> tuple[float, list[tuple[str, Path]]]:
    """The duration of a case [s], and its pages by name."""
    place.mkdir()
    (place / "part.nc").write_text(case.program)
    (place / "setup.toml").write_text(case.sheet)
    usual = ["plan", str(place / "part.nc"), *case.words, "--effort", "low", "--no-report", "--tip-tolerance"]
    first, second, report, page = (place / name for name in ("first", "second", "report.html", "compare.html"))
    for words in (
        [*usual, "10um", "-o", str(first)],
        [*usual, "5um", "-o", str(second)],
        ["compare", str(first), str(second), "--page", str(page)],
    ):
        subprocess.run([*COMMAND, *words], stdout=subprocess.DEVNULL, check=True)
    record = read_plan(first)
    motion = PlannedMotion.load(first, record)
    assert motion is not None
    # the stock is cut in the cells of a page: a plan would cut it in ten times as many
    write_report(
        report, motion.trajectory, motion.setpoints, motion.toolpath, None, record, None, motion.program,
        load_setup(place / "setup.toml"),
    )  # fmt: skip
    return record.duration_s, [("report", report), ("compare", page)]


@contextmanager
def browser() -> Iterator[tuple[Any, int]]:
    """A page of Chromium, and the process that the browser is."""
    import psutil
    from playwright.sync_api import sync_playwright

    executable = next(found for name in BROWSERS if (found := shutil.which(name)))
    with sync_playwright() as play:
        before = set(psutil.Process().children(recursive=True))
        opened = play.chromium.launch(executable_path=executable, args=GRAPHICS)
        process = next(each for each in psutil.Process().children(recursive=True) if each not in before)
        try:
            yield opened.new_page(viewport=WINDOW), process.pid
        finally:
            opened.close()


def memory(process: int) -> float:
    """Of a process and all that it started [MB]."""
    import psutil

    whole = psutil.Process(process)
    return sum(each.memory_full_info().pss for each in (whole, *whole.children(recursive=True))) / 1e6


def measured(file: Path, duration: float) -> list[str]:
    """Size, time to the first picture, frames a second and the longest frame at each rate, and memory."""
    with browser() as (page, process):
        page.goto(file.resolve().as_uri())
        first = page.evaluate(FIRST_PICTURE)
        figures = [f"{file.stat().st_size / 1e6:.2f}", f"{first / 1e3:.2f}"]
        for rate in RATES:
            page.select_option("#rate", rate)
            page.evaluate(f"toolpace.seek({0.4 * duration})")
            per_second, longest = page.evaluate(FRAMES, PLAYED)
            figures += [f"{per_second:.1f}", f"{longest:.0f}"]
        return [*figures, f"{memory(process):.0f}"]


def main() -> None:
    """Measure all, and write the page."""
    known = cases()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", action="append", choices=list(known))
    parser.add_argument("--out", type=Path, default=RESULTS / "pages.md")
    options = parser.parse_args()
    began = time.perf_counter()
    rates = [f"{what}, {rate} x" for rate in RATES for what in ("frames/s", "longest frame [ms]")]
    table = Table("Pages", ["page", "motion", "size [MB]", "first picture [s]", *rates, "memory [MB]"], words=2)
    with tempfile.TemporaryDirectory() as folder:
        for name in options.case or known:
            duration, pages = planned(known[name], Path(folder) / name)
            for kind, file in pages:
                table.lines.append([f"{kind}, {name}", format_time(duration), *measured(file, duration)])
                print(*table.lines[-1], flush=True)
    table.show()
    written = written_by("python -m benchmarks.pages", f"in {time.perf_counter() - began:.0f} s")
    load = f"Load of the machine at the end: {os.getloadavg()[0]:.1f}."
    options.out.write_text(f"# Pages in a browser\n\n{written} {load}\n\n{table.markdown()}")


if __name__ == "__main__":
    main()
