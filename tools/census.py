"""How the house stands: rooms, modules, circles of imports, long functions, names that stand for several things.

    python tools/census.py [--strict] [FOLDER]

FOLDER is a package, `src/toolpace` unless given. With `--strict` it ends with 1 where modules import each other in a
circle, there are more than 17 rooms, a folder holds more than 14 modules, or a function of the kernels has more than
80 lines or 12 parameters.
Read from the sources alone: nothing is imported. An import within a function is an import too.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

MOST_ROOMS = 17
"""Folders at the top: fifteen, and the two that all stand on, `common` and `kernels`."""
MOST_MODULES = 14
"""In a folder; `__init__.py` and `__main__.py`, the ways in, are not counted."""
MOST_LINES, MOST_PARAMETERS = 80, 12
"""Of a function of the kernels."""
SMALL = 60
"""Lines below which a module with one importer may be a part of it."""
TUNED = ("planning", "path", "kernels")
"""Rooms whose numeric constants are counted."""
SHOWN = 8
"""Lines of each list."""

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
Graph = dict[str, set[str]]


@dataclass(frozen=True)
class Measured:
    """A function, where it stands, and its size."""

    name: str
    file: Path
    lines: int
    parameters: int
    in_kernels: bool

    @property
    def too_large(self) -> bool:
        """Whether it is more than a function of the kernels may be."""
        return self.in_kernels and (self.lines > MOST_LINES or self.parameters > MOST_PARAMETERS)


@dataclass
class Census:
    """What was counted."""

    modules: int = 0
    rooms: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    """Lines of each folder at the top."""
    beside: list[str] = field(default_factory=list)
    """Modules at the top."""
    longest: tuple[int, str] = (0, "")
    """Lines of the longest module, and which."""
    empty: int = 0
    """`__init__.py` of one line or none."""
    lone: list[str] = field(default_factory=list)
    """Small modules that one other imports."""
    constants: int = 0
    """Numeric constants of modules, in the rooms TUNED."""
    folders: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    functions: list[Measured] = field(default_factory=list)
    homes: dict[str, list[str]] = field(default_factory=lambda: defaultdict(list))
    """Modules that define each top-level name."""
    untyped: int = 0
    """Annotations that say Any."""
    circles: list[list[str]] = field(default_factory=list)

    @property
    def shared_names(self) -> dict[str, list[str]]:
        """Top-level names that stand for several things."""
        return {name: homes for name, homes in sorted(self.homes.items()) if len(homes) > 1}

    @property
    def crowded(self) -> list[str]:
        """Folders with too many modules."""
        return [folder for folder, count in self.folders.items() if count > MOST_MODULES]

    @property
    def too_large(self) -> list[Measured]:
        """Functions of the kernels that are too long or take too much."""
        return [function for function in self.functions if function.too_large]


def modules_of(package: Path) -> dict[str, Path]:
    """Every module of a package by its name with dots; a folder's name stands for its `__init__.py`."""
    names = {}
    for file in sorted(package.rglob("*.py")):
        parts = [package.name, *file.relative_to(package).with_suffix("").parts]
        names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return names


def imports_of(tree: ast.Module, module: str, is_package: bool, known: dict[str, Path]) -> set[str]:
    """The modules of the package that a module imports, wherever in it."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = module.split(".")[: None if is_package and node.level == 1 else is_package - node.level]
                base = ".".join([*above, *base.split(".")] if base else above)
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                found.add(inner if inner in known else base)
    return (found & known.keys()) - {module}


def circles(graph: Graph) -> list[list[str]]:
    """Strongly connected components of more than one module (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            component = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(component) > 1:
                found.append(sorted(component))

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return found


def functions_of(tree: ast.Module, file: Path, in_kernels: bool) -> Iterator[Measured]:
    """Every function and method; `self` and `cls` are no parameters."""
    for node in ast.walk(tree):
        if isinstance(node, FUNCTIONS):
            given = node.args
            names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
            count = len([name for name in names if name not in ("self", "cls")])
            count += (given.vararg is not None) + (given.kwarg is not None)
            yield Measured(node.name, file, (node.end_lineno or node.lineno) - node.lineno + 1, count, in_kernels)


def top_level_names(tree: ast.Module) -> Iterator[str]:
    """Classes and functions of a module, names with two underscores left out."""
    for node in tree.body:
        if isinstance(node, (ast.ClassDef, *FUNCTIONS)) and not node.name.startswith("__"):
            yield node.name


def is_numeric_constant(node: ast.stmt) -> bool:
    """Whether a statement of a module names a number, or several."""
    if not isinstance(node, ast.Assign):
        return False
    values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
    numbers = [value.operand if isinstance(value, ast.UnaryOp) else value for value in values]
    return any(isinstance(each, ast.Constant) and type(each.value) in (int, float) for each in numbers)


def census(package: Path) -> Census:
    """All figures of a package."""
    known = modules_of(package)
    graph: Graph = {}
    counted = Census(modules=len(known))
    for module, file in known.items():
        text = file.read_text(encoding="utf-8")
        tree, lines = ast.parse(text, str(file)), text.count("\n")
        graph[module] = imports_of(tree, module, file.name == "__init__.py", known)
        place = file.relative_to(package)
        if len(place.parts) > 1:
            counted.rooms[place.parts[0]] += lines
        elif not file.name.startswith("__"):
            counted.beside.append(place.stem)
        counted.longest = max(counted.longest, (lines, str(place)))
        counted.empty += file.name == "__init__.py" and lines <= 1
        if place.parts[0] in TUNED:
            counted.constants += sum(is_numeric_constant(node) for node in tree.body)
        if not file.name.startswith("__"):
            counted.folders[str(file.parent.relative_to(package.parent))] += 1
        inside = "kernels" in file.relative_to(package).parts
        counted.functions += functions_of(tree, file.relative_to(package), inside)
        for name in top_level_names(tree):
            counted.homes[name].append(module)
        counted.untyped += sum(isinstance(node, ast.Name) and node.id == "Any" for node in ast.walk(tree))
    counted.circles = circles(graph)
    for module, file in known.items():
        importers = [other for other, imported in graph.items() if module in imported and other != package.name]
        lines = file.read_text(encoding="utf-8").count("\n")
        if len(importers) == 1 and lines < SMALL and file.name != "__init__.py":
            counted.lone.append(f"{module.partition('.')[2]} ({lines}), for {importers[0].partition('.')[2]}")
    return counted


def listed(title: str, count: object, lines: list[str], shown: int = SHOWN) -> None:
    """A figure, and what is behind it."""
    print(f"{title:<44}{count}")
    for line in lines[:shown]:
        print(f"    {line}")
    if len(lines) > shown:
        print(f"    and {len(lines) - shown} more")


def show(found: Census) -> None:
    """All figures, in words."""
    rooms = [f"{lines:6} lines {room}" for room, lines in sorted(found.rooms.items())]
    listed("rooms at the top", len(found.rooms), rooms, len(rooms))
    listed("modules beside them", len(found.beside), [", ".join(found.beside)] if found.beside else [])
    listed("modules", found.modules, [])
    listed("lines", sum(found.rooms.values()), [f"{found.longest[0]:6} lines {found.longest[1]}, the longest"])
    listed("__init__.py with a first line alone", found.empty, [])
    listed(f"modules under {SMALL} lines with one importer", len(found.lone), found.lone)
    listed(f"numeric constants in {', '.join(TUNED)}", found.constants, [])
    listed("circles of imports", len(found.circles), [" <-> ".join(circle) for circle in found.circles])
    folders = sorted(found.folders.items(), key=lambda one: -one[1])
    listed("most modules in a folder", folders[0][1], [f"{count:3} {folder}" for folder, count in folders[:5]])
    for title, functions in (
        ("", found.functions),
        (" of the kernels", [function for function in found.functions if function.in_kernels]),
    ):
        if functions:
            long = sorted(functions, key=lambda one: -one.lines)[:5]
            wide = sorted(functions, key=lambda one: -one.parameters)[:5]
            listed(f"lines of the longest function{title}", long[0].lines,
                   [f"{one.lines:3} {one.name}, {one.file}" for one in long])  # fmt: skip
            listed(f"most parameters of a function{title}", wide[0].parameters,
                   [f"{one.parameters:3} {one.name}, {one.file}" for one in wide])  # fmt: skip
    names = sorted(found.shared_names.items(), key=lambda one: -len(one[1]))
    listed("classes and functions with a shared name", len(names),
           [f"{name}: {', '.join(home.partition('.')[2] for home in homes)}" for name, homes in names])  # fmt: skip
    listed("annotations that say Any", found.untyped, [])


def broken(found: Census) -> list[str]:
    """What a strict census does not let pass."""
    return [
        *(f"modules import each other: {' <-> '.join(circle)}" for circle in found.circles),
        *([f"{len(found.rooms)} rooms, {MOST_ROOMS} at most"] if len(found.rooms) > MOST_ROOMS else []),
        *(f"{folder} holds {found.folders[folder]} modules, {MOST_MODULES} at most" for folder in found.crowded),
        *(
            f"{one.name} in {one.file} has {one.lines} lines and {one.parameters} parameters, "
            f"{MOST_LINES} and {MOST_PARAMETERS} at most"
            for one in found.too_large
        ),
    ]


def main() -> int:
    """Count, print, and judge where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[1] / "src" / "toolpace")
    parser.add_argument("--strict", action="store_true", help="end with 1 where the rules of the house are broken")
    options = parser.parse_args()
    found = census(options.folder.resolve())
    show(found)
    faults = broken(found) if options.strict else []
    for fault in faults:
        print(f"error: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
