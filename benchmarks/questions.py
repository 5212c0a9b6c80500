"""Three questions of a new user, answered in the app and its report by clicks and keys, with the seconds that takes.

    python -m benchmarks.questions [--program NAME]... [--out FILE]

    which block costs most?                          report: the tab of the longest blocks
    why is the tool slow at 12 s?                    report: 12 into the clock, and what stands beside it
    what would 20 µm of tolerance bring?             app: the button that plans with twice the tolerance of 10 µm

A browser is driven as a person would: what is not on the page is not used. Waiting is measured: from an action until
its answer is there. The time of hand and head is an estimate by the keystroke-level model (Card, Moran, Newell: The
keystroke-level model for user performance time with interactive systems, Comm. ACM 23, 1980). Writes questions.md.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.machine import RESULTS, written_by
from benchmarks.pages import browser
from benchmarks.tables import Table
from testbed.positioned import positioned
from toolpace.cli.demo_programs import impeller_program

DECIDE, POINT, CLICK, KEY, HOME = 1.35, 1.10, 0.20, 0.28, 0.40
"""Times of the model [s]: to make up one's mind, to point, to press and let go, a key, hand to keyboard and back."""
PATIENCE = 600e3
"""For a plan [ms]."""


@dataclass
class Person:
    """One who clicks and types on a page, and what that took."""

    clicks: int = 0
    keys: int = 0
    loads: int = 0
    waited: float = 0.0
    """[s]"""

    def click(self, page: Any, what: str) -> None:
        """Click on something, and see what comes of it."""
        began = time.perf_counter()
        page.click(what)
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        self.clicks += 1
        self.waited += time.perf_counter() - began

    def write(self, page: Any, words: str) -> None:
        """Type words, and a return."""
        began = time.perf_counter()
        page.keyboard.type(words)
        page.keyboard.press("Enter")
        self.keys += len(words) + 1
        self.waited += time.perf_counter() - began

    def wait(self, page: Any, shown: str) -> str:
        """Wait until something is there; its text."""
        began = time.perf_counter()
        found = page.locator(shown).first
        found.wait_for(timeout=PATIENCE)
        self.waited += time.perf_counter() - began
        return " ".join(found.inner_text().split())

    @property
    def by_hand(self) -> float:
        """Of hand and head, by the model [s]."""
        return self.clicks * (DECIDE + POINT + CLICK) + self.keys * KEY + (2 * HOME + DECIDE if self.keys else 0.0)

    def row(self, question: str, answer: str) -> list[str]:
        """A line of the table."""
        figures = f"{self.waited:.1f}", f"{self.by_hand:.1f}", f"{self.waited + self.by_hand:.0f}"
        return [question, answer, str(self.clicks), str(self.keys), str(self.loads), *figures]


@contextmanager
def app(folder: Path) -> Iterator[str]:
    """The address of the app of a folder."""
    command = [sys.executable, "-m", "toolpace", "app", "--folder", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield next(found[0] for line in process.stdout if (found := re.search(r"http\S+", line)))
        finally:
            process.terminate()


def asked(page: Any, program: str, machine: str, text: str) -> list[list[str]]:
    """What a person who has a machine does with one program that is dropped, question by question."""
    rows = []
    person = Person(loads=1)
    page.set_input_files("#file", [{"name": program, "mimeType": "", "buffer": text.encode()}])
    person.clicks += 1  # on the file
    person.wait(page, "[data-focus=start]:not([disabled])")
    person.wait(page, "#program .good")
    person.click(page, f"[data-focus='on {machine}']")
    person.click(page, "[data-focus=start]")
    took = person.wait(page, ".job .time")
    rows.append(person.row(f"{program}: plan it", took))

    person = Person(loads=1)
    began = time.perf_counter()
    with page.context.expect_page() as opened:
        page.click("text=Look >> nth=0")
    report = opened.value
    report.wait_for_load_state()
    person.clicks += 1
    person.wait(report, "#listing .row")
    person.waited = time.perf_counter() - began
    person.click(report, "[data-tab=blocks]")
    rows.append(person.row("which block costs most?", person.wait(report, '[data-panel="blocks"] tr')))

    person = Person()
    person.click(report, "#at")
    person.write(report, "12")
    rows.append(person.row("why is the tool slow at 12 s?", person.wait(report, "#readout")))
    report.close()

    person = Person()
    person.click(page, "text=Try 20 µm >> nth=0")
    person.wait(page, ".job .time >> nth=1")
    answer = f"{person.wait(page, '.job .time')}: {person.wait(page, '.job .top .quiet')}"
    rows.append(person.row("what would 20 µm bring?", answer))
    return rows


def main() -> None:
    """Ask all, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    programs = {
        "demo.ngc": ("xyzac-trunnion", impeller_program()),
        "positioned.nc": ("xyzbc-trunnion", positioned(blocks=141)),
    }
    parser.add_argument("--program", action="append", choices=list(programs))
    parser.add_argument("--out", type=Path, default=RESULTS / "questions.md")
    options = parser.parse_args()
    heads = ["question", "answer", "clicks", "keys", "page loads", "waiting [s]", "hand and head [s]", "together [s]"]
    table = Table("Questions", heads, words=2)
    with tempfile.TemporaryDirectory() as folder, app(Path(folder) / "app") as address, browser() as (page, _):
        page.goto(address)
        for program in options.program or programs:
            table.lines += asked(page, program, *programs[program])
            print(*table.lines[-4:], sep="\n", flush=True)
    table.show()
    about = (
        "`positioned.nc` has 25 operations in tilted planes. Waiting is measured; hand and head are estimated by the "
        f"keystroke-level model. Load of the machine at the end: {os.getloadavg()[0]:.1f}."
    )
    written = written_by("python -m benchmarks.questions")
    options.out.write_text(f"# Three questions of a new user\n\n{written} {about}\n\n{table.markdown()}")


if __name__ == "__main__":
    main()
