"""The pages for those who come from other libraries are true, and the reference is whole."""

from __future__ import annotations

import contextlib
import importlib.util
import re
from collections.abc import Iterable
from pathlib import Path

import pytest

import toolpace as tp
from toolpace.cli import demo_programs
from tools import pages

TOP = Path(__file__).parents[1]
DOCS = TOP / "docs"
BLOCK = re.compile(r"^```(python|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NOTES = sorted(page for folder in ("design", "notebook") for page in (DOCS / folder).glob("*.md"))
SOURCE = TOP / "src" / "toolpace"
FOLDERS = ("src", "tests", "testbed", "tools", "benchmarks", "examples", "docs")
MODULES = [*TOP.glob("*.py"), *(path for folder in FOLDERS for path in (TOP / folder).rglob("*.py"))]
AS_IT_WAS = "docs/notebook/mutation.md"
"""Its tables have the names that modules had when they were measured."""
WRITTEN = sorted(
    {"README.md", "CONTRIBUTING.md", *(str(page.relative_to(TOP)) for page in DOCS.glob("*.md")),
     *(str(page.relative_to(TOP)) for page in DOCS.glob("[!bg]*/*.md"))} - {AS_IT_WAS}
)  # fmt: skip
"""Pages that people write: those of benchmarks and gallery are made."""
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


def missing_modules(names: Iterable[str]) -> list[str]:
    """Those of the names that no module's path ends with."""
    paths = [f"/{path.as_posix()}" for path in MODULES]
    return [name for name in names if not any(path.endswith(f"/{name}") for path in paths)]


def exists(path: Path) -> bool:
    """Whether there is a file or folder, or a module of that name."""
    return path.exists() or path.with_suffix(".py").exists()


def is_public(name: str) -> bool:
    """Whether toolpace has the module, function, class or field of a class, annotated or made by its `__init__`."""
    found: object = tp
    for part in name.strip(".").split("."):
        made = getattr(getattr(found, "__init__", None), "__code__", None)
        fields = {field for base in getattr(found, "__mro__", ()) for field in getattr(base, "__annotations__", {})}
        if part in fields or (made is not None and part in made.co_names):
            return True
        if not hasattr(found, part):
            with contextlib.suppress(ImportError):
                importlib.import_module(f"{getattr(found, '__name__', '')}.{part}")
        if not hasattr(found, part):
            return False
        found = getattr(found, part)
    return True


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
def test_files_that_a_document_links_to_exist(document):
    text = (TOP / document).read_text(encoding="utf-8")
    links = set(re.findall(r"\]\(((?!http)[\w./-]+)\)", text))
    assert [link for link in links if not ((TOP / document).parent / link).exists()] == []


@pytest.mark.parametrize("document", WRITTEN)
def test_files_and_folders_that_a_document_names_exist(document):
    """Modules by the end of their path, with or without ending; other paths from the top, a package or beside it."""
    text = (TOP / document).read_text(encoding="utf-8")
    assert missing_modules(re.findall(r"`((?:[\w-]+/)*\w+\.py)`", text)) == []
    places = (TOP, SOURCE.parent, SOURCE, (TOP / document).parent, TOP / "benchmarks" / "results")
    rooms = {*FOLDERS, "toolpace", *(path.name for path in SOURCE.iterdir())}
    paths = [name for name in re.findall(r"`([\w-]+/[\w./-]*)`", text) if name.split("/")[0] in rooms]
    paths += re.findall(r"`((?:[\w-]+/)+[\w.-]+\.(?:md|json|toml))`", text)
    assert [name for name in paths if not any(exists(at / name) for at in places)] == []


@pytest.mark.parametrize("document", WRITTEN)
def test_names_that_a_document_puts_behind_a_file_stand_in_it(document):
    """Such as "`machine/file.py` (`JointFile`, `read_machine`)", or in the next column of a table."""
    text = (TOP / document).read_text(encoding="utf-8")
    for module, names in re.findall(r"`((?:[\w-]+/)+\w+\.py)`(?: \(| \| )((?:`[\w.]+`(?:, )?)+)", text):
        code = "".join(
            path.read_text(encoding="utf-8") for path in MODULES if f"/{path.as_posix()}".endswith(f"/{module}")
        )
        words = set(re.findall(r"\w+", code))
        assert set(re.findall(r"\w+", names)) <= words, module


@pytest.mark.filterwarnings("ignore:toolpace.deflect is called:DeprecationWarning")
@pytest.mark.parametrize("document", WRITTEN)
def test_public_names_in_a_document_exist(document):
    """Such as `tp.read_text(...)`, `toolpace.errors`, or `Path.fit`."""
    text = (TOP / document).read_text(encoding="utf-8")
    names = re.findall(r"`(?:toolpace|tp)\.([\w.]+)", text)
    names += [name for name in re.findall(r"`([A-Z]\w+\.[a-z]\w*)", text) if name.split(".")[0] in tp.__all__]
    assert [name for name in names if not is_public(name)] == []


def test_modules_that_code_names_exist():
    named = {
        name
        for path in MODULES
        for name in re.findall(r"(?<![\w/.-])((?:\w+/)*\w+\.py)\b", path.read_text(encoding="utf-8"))
    }
    assert missing_modules(named) == []


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
