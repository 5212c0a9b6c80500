"""Counts how often each branch of the reading modules is taken: a statement is put into each when it is imported."""

from __future__ import annotations

import ast
import builtins
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from types import CodeType, ModuleType
from typing import Any

PACKAGE = "toolpace.programs.reading"
NAME = "_branches_taken"
MOST = 1 << 14
"""Branches there may be."""
TAKEN = [0] * MOST
"""How often each branch has been taken since the last `features`."""
MOST_TIMES = 8
"""Powers of two that are told apart in how often a branch is taken."""
_known = 0


def install() -> None:
    """Count the branches of what is imported from now on."""
    setattr(builtins, NAME, TAKEN)
    sys.meta_path.insert(0, _Finder())


def features() -> frozenset[int]:
    """What was taken since the last call, a number for each branch and power of two of how often; begins anew."""
    found = frozenset(
        branch * MOST_TIMES + min(times.bit_length(), MOST_TIMES) - 1
        for branch, times in enumerate(TAKEN[:_known])
        if times
    )
    TAKEN[:_known] = [0] * _known
    return found


def branches() -> int:
    """Branches of all modules that were imported."""
    return _known


class _Finder(MetaPathFinder):
    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != PACKAGE and not name.startswith(PACKAGE + "."):
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


class _Loader(SourceFileLoader):
    def path_stats(self, path: Any) -> Any:
        """Neither read nor write compiled files: they have no counters."""
        raise OSError

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> CodeType:  # type: ignore[override]
        tree = _Counted().visit(ast.parse(data, path))
        return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)


class _Counted(ast.NodeTransformer):
    """Puts a counter at the beginning of every body, and on the way past an `if` without `else`."""

    def _of(self, body: list[ast.stmt], line: int) -> list[ast.stmt]:
        global _known
        first = 1 if body and isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant) else 0
        counter = ast.parse(f"{NAME}[{_known}] += 1").body[0]
        for node in ast.walk(counter):
            if hasattr(node, "lineno"):
                node.lineno = node.end_lineno = line  # type: ignore[attr-defined]
        _known += 1
        return [*body[:first], counter, *body[first:]]

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        self.generic_visit(node)
        node.body = self._of(node.body, node.lineno)
        return node

    def visit_If(self, node: ast.If) -> ast.AST:
        self.generic_visit(node)
        node.body, node.orelse = self._of(node.body, node.lineno), self._of(node.orelse, node.lineno)
        return node

    def visit_For(self, node: ast.For) -> ast.AST:
        self.generic_visit(node)
        node.body = self._of(node.body, node.lineno)
        return node

    def visit_While(self, node: ast.While) -> ast.AST:
        self.generic_visit(node)
        node.body = self._of(node.body, node.lineno)
        return node

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> ast.AST:
        self.generic_visit(node)
        node.body = self._of(node.body, node.lineno)
        return node
