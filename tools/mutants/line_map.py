"""Which tests run which line of the library, and how long each takes: measured by one run of the suite."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

OUT = Path("out/mutants")
TIMES = OUT / "seconds.json"
DATA = OUT / "coverage"
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


class Recorder:
    """Tells coverage which test runs, and keeps how long it took."""

    def __init__(self) -> None:
        import coverage

        self.coverage = coverage.Coverage.current()
        self.seconds: dict[str, float] = {}

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        if self.coverage is not None:
            self.coverage.switch_context(nodeid)

    def pytest_runtest_logreport(self, report: object) -> None:
        nodeid, duration = report.nodeid, report.duration  # type: ignore[attr-defined]
        self.seconds[nodeid] = self.seconds.get(nodeid, 0.0) + duration

    def pytest_sessionfinish(self) -> None:
        TIMES.write_text(json.dumps(self.seconds), encoding="utf-8")


def record(arguments: list[str]) -> int:
    """Run the suite once, watched."""
    OUT.mkdir(parents=True, exist_ok=True)
    code = "import sys, pytest; from tools.mutants.line_map import Recorder; " \
           "sys.exit(pytest.main(['-q', *sys.argv[1:]], plugins=[Recorder()]))"
    run = [sys.executable, "-m", "coverage", "run", "--source=src/toolpace", f"--data-file={DATA}"]
    script = OUT / "run.py"
    script.write_text(code, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path.cwd()), os.environ.get("PYTHONPATH", "")])}
    return subprocess.call([*run, str(script), *arguments], env=environment)


@cache
def function_lines(file: Path) -> frozenset[int]:
    """Lines of the bodies of all functions of a module."""
    functions = (each for each in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(each, FUNCTIONS))
    return frozenset(k for each in functions for k in range(each.body[0].lineno, (each.end_lineno or 0) + 1))


def in_function(file: Path, line: int) -> bool:
    """Whether a line runs where something is called; else it runs on import, in whatever test comes first."""
    return line in function_lines(file)


class LineMap:
    """What `record` found."""

    def __init__(self) -> None:
        import coverage

        self.seconds: dict[str, float] = json.loads(TIMES.read_text(encoding="utf-8"))
        data = coverage.CoverageData(str(DATA))
        data.read()
        self.files = {Path(name).relative_to(Path.cwd() / "src").as_posix(): name for name in data.measured_files()}
        self.data = data
        self.known: dict[str, dict[int, list[str]]] = {}

    def tests_of(self, file: str, line: int) -> list[str]:
        """The tests that run a line (file below src), the quickest first; those of the file where it runs on import."""
        if file not in self.files:
            return []
        if file not in self.known:
            self.known[file] = self.data.contexts_by_lineno(self.files[file])
        lines = self.known[file]
        tests = [each for each in lines.get(line, []) if each]
        if line in lines and not in_function(Path("src") / file, line):
            tests = list({each for some in lines.values() for each in some if each})
        return sorted(tests, key=lambda name: self.seconds.get(name, 0.0))
