"""The pages for those who come from other libraries are true, and the reference is whole."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

import toolpace as tp
from toolpace.cli import demo_programs
from tools import pages

TOP = Path(__file__).parents[1]
DOCS = TOP / "docs"
BLOCK = re.compile(r"^```(python|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NOTES = sorted(page for folder in ("design", "notebook") for page in (DOCS / folder).glob("*.md"))
LONGEST = 250
"""Lines of a page of the design."""
LONGEST_README = 120
PEERS = ("toppra", "ruckig")
HERE = {name for name in PEERS if importlib.util.find_spec(name)}
"""Peers that are installed; where there is none for a machine, what is theirs on the pages is left out."""


def blocks_of(page: str) -> list[tuple[str, str]]:
    """The code blocks of a page, each with what it is said to print."""
    found = BLOCK.findall((DOCS / "coming_from" / f"{page}.md").read_text(encoding="utf-8"))
    pairs = zip(found, [*found[1:], ("", "")])
    return [(code, said if after == "text" else "") for (kind, code), (after, said) in pairs if kind == "python"]


def needs(code: str, peer: str) -> bool:
    """Whether a block is the peer's: it imports it, or calls what its blocks made."""
    return re.search(rf"^import {peer}|^from {peer}|\bmove\(", code, re.MULTILINE) is not None


@pytest.mark.parametrize("page", PEERS)
def test_pages_print_what_they_say(page, capsys):
    names: dict[str, object] = {}
    ours = 0
    for code, said in blocks_of(page):
        if needs(code, page) and page not in HERE:
            continue
        exec(compile(code, f"{page}.md", "exec"), names)
        assert capsys.readouterr().out == said
        ours += not needs(code, page)
    assert ours >= 3


def test_every_public_name_is_in_the_reference():
    reference = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "api").glob("*.md"))
    entries = set(re.findall(r"^\.\. auto\w+:: toolpace\.([\w.]+)$", reference, re.MULTILINE))
    public = set(tp.__all__) - {"__version__", "deflection", "ToolpaceError"}
    public |= {f"deflection.{name}" for name in tp.deflection.__all__} | {"errors.ToolpaceError"}
    assert public <= entries


@pytest.mark.parametrize("folder", ["design", "notebook"])
def test_every_note_is_in_the_contents(folder):
    contents = (DOCS / folder / "index.md").read_text(encoding="utf-8").split()
    assert {page.stem for page in (DOCS / folder).glob("*.md")} - {"index"} <= set(contents)


def test_pages_are_short():
    lines = {page.name: len(page.read_text(encoding="utf-8").splitlines()) for page in (DOCS / "design").glob("*.md")}
    assert {page: count for page, count in lines.items() if count > LONGEST} == {}
    assert len((TOP / "README.md").read_text(encoding="utf-8").splitlines()) <= LONGEST_README


@pytest.mark.parametrize("page", sorted(page.stem for page in (DOCS / "tutorial").glob("*.md")))
def test_tutorial_runs(page, tmp_path, monkeypatch):
    (tmp_path / "part.ngc").write_text(demo_programs.spiral_program(60), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for kind, code in BLOCK.findall((DOCS / "tutorial" / f"{page}.md").read_text(encoding="utf-8")):
        if kind == "python":
            exec(compile(code, f"{page}.md", "exec"), names)


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", *(str(page.relative_to(TOP)) for page in NOTES)])
def test_files_that_a_document_names_exist(document):
    """Named from the top of the project, from the package, from the results of the benchmarks, or from beside it."""
    text = (TOP / document).read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w./-]+/[\w.-]+\.(?:py|md|json|toml))`|\]\(((?!http)[\w./-]+)\)", text))
    places = (TOP, TOP / "src" / "toolpace", (TOP / document).parent)
    missing = [name for pair in named for name in pair if name and not any((at / name).exists() for at in places)]
    assert not missing


def test_tables_are_those_of_the_results():
    stale = [path.name for path in pages.pages() if pages.written(path) != path.read_text(encoding="utf-8")]
    assert not stale, "python tools/pages.py writes them"
    assert len(pages.pages()) >= 3


def test_peers_by_the_other_file_of_the_same_run():
    """planner.json through our medians; planner.md has those that the benchmark itself worked out."""
    lines = (TOP / "benchmarks" / "results" / "planner.md").read_text(encoding="utf-8").splitlines()
    told = [line.strip("|").split("|") for line in lines if line.startswith("| IPOPT | 1000 | 27 |")]
    ours = next(line for line in pages.peers("").splitlines() if line.startswith("| IPOPT")).strip("|").split("|")
    assert [float(word) for word in told[0][4:8]] == [float(word) for word in ours[1:5]]
