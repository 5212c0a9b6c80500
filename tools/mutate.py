"""Mutation testing: change a file in one small way after the other, and see whether the tests notice.

    python tools/mutate.py FILE [--tests PATH ...] [--limit N] [--seed N] [--only NAME,...] [--list]

Mutants: comparisons exchanged, conditions negated, + and - and * and / exchanged, min and max exchanged, constants
doubled (and 0 made 1), statements removed, results of functions replaced by None. Each runs the tests given, in a
process of its own, until the first that fails; one that runs three times as long as the unchanged file counts as
killed. The file is put back after each mutant, and when the run is interrupted. Survivors are printed, one a line;
exit code 1 where there are any.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

# What every child would else import for itself; nothing of toolpace, which is what changes.
import hypothesis  # noqa: F401
import msgspec  # noqa: F401
import numba  # noqa: F401
import numpy  # noqa: F401
import pytest
import scipy.optimize  # noqa: F401

COMPARISONS = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
PAIRS = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "argmax": "argmin",
         "any": "all", "all": "any"}  # fmt: skip
STATEMENTS = (ast.Assign, ast.AugAssign, ast.Raise, ast.Expr, ast.Continue, ast.Break)

Mutant = tuple[int, str, ast.Module]
"""Line, what was changed, and the changed module."""


def mutants(tree: ast.Module) -> Iterator[Mutant]:
    """All of them, in the order of the file."""
    places = [node for node in ast.walk(tree) if hasattr(node, "lineno") and not isinstance(node, ast.alias)]
    for index, node in enumerate(places):
        for name in changes(node):
            changed = copy.deepcopy(tree)
            twins = [n for n in ast.walk(changed) if hasattr(n, "lineno") and not isinstance(n, ast.alias)]
            before = ast.unparse(twins[index])
            apply(changed, twins[index], name)
            shown = before.splitlines()[0][:70]
            yield node.lineno, f"{name}: {shown}", ast.fix_missing_locations(changed)


def changes(node: ast.AST) -> list[str]:
    """What can be changed at a node."""
    if isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISONS:
        return ["compare", "negate"]
    if isinstance(node, (ast.If, ast.While, ast.IfExp)):
        return ["negate condition"]
    if isinstance(node, (ast.BinOp, ast.AugAssign)) and type(node.op) in OPERATORS:
        return ["operator", *(["remove"] if isinstance(node, ast.AugAssign) else [])]
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return ["constant"]
    if isinstance(node, (ast.Name, ast.Attribute)) and (node.id if isinstance(node, ast.Name) else node.attr) in PAIRS:
        return ["min and max"]
    if isinstance(node, ast.Return) and node.value is not None:
        return ["return None"]
    if isinstance(node, STATEMENTS) and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
        return ["remove"]
    return []


def apply(tree: ast.Module, node: ast.AST, name: str) -> None:
    """Make one change in place."""
    if name == "compare" and isinstance(node, ast.Compare):
        node.ops[0] = COMPARISONS[type(node.ops[0])]()
    elif name == "operator" and isinstance(node, (ast.BinOp, ast.AugAssign)):
        node.op = OPERATORS[type(node.op)]()
    elif name == "constant" and isinstance(node, ast.Constant):
        node.value = node.value * 2 if node.value else node.value + 1
    elif name == "negate condition" and isinstance(node, (ast.If, ast.While, ast.IfExp)):
        node.test = ast.UnaryOp(ast.Not(), node.test)
    elif name == "min and max" and isinstance(node, ast.Name):
        node.id = PAIRS[node.id]
    elif name == "min and max" and isinstance(node, ast.Attribute):
        node.attr = PAIRS[node.attr]
    elif name == "return None" and isinstance(node, ast.Return):
        node.value = ast.Constant(None)
    else:
        replacement = ast.UnaryOp(ast.Not(), copy.copy(node)) if name == "negate" else ast.Pass()
        for parent in ast.walk(tree):
            for field, value in ast.iter_fields(parent):
                if value is node:
                    setattr(parent, field, replacement)
                elif isinstance(value, list) and node in value:
                    value[value.index(node)] = replacement


def survives(tests: list[str], timeout: float) -> bool:
    """Whether all tests pass, in a child that has the libraries at hand and imports toolpace anew."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            signal.alarm(int(timeout) + 1)
            nowhere = os.open(os.devnull, os.O_RDWR)
            for handle in (0, 1, 2):
                os.dup2(nowhere, handle)
            code = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests]))
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1] == 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("--tests", nargs="+", default=["tests"])
    parser.add_argument("--limit", type=int, default=0, help="most mutants, chosen at random")
    parser.add_argument("--seed", type=int, default=20261122)
    parser.add_argument("--only", default="", help="functions, by name, with commas; else the whole file")
    parser.add_argument("--list", action="store_true", help="print the mutants, run none")
    given = parser.parse_args()
    sys.dont_write_bytecode = True
    text = given.file.read_text(encoding="utf-8")
    tree = ast.parse(text)
    found = list(mutants(tree))
    if given.only:
        spans = [(n.lineno, n.end_lineno or n.lineno) for n in ast.walk(tree)
                 if isinstance(n, ast.FunctionDef) and n.name in given.only.split(",")]  # fmt: skip
        found = [mutant for mutant in found if any(low <= mutant[0] <= high for low, high in spans)]
    if given.limit and len(found) > given.limit:
        found = sorted(random.Random(given.seed).sample(found, given.limit), key=lambda mutant: mutant[0])
    if given.list:
        for line, name, _ in found:
            print(f"{given.file}:{line}: {name}")
        return 0
    began = time.perf_counter()
    if not survives(given.tests, 3600.0):
        print("the tests fail on the unchanged file")
        return 2
    timeout = 3.0 * (time.perf_counter() - began) + 20.0
    left = 0
    try:
        for line, name, changed in found:
            given.file.write_text(ast.unparse(changed), encoding="utf-8")
            if survives(given.tests, timeout):
                left += 1
                print(f"survived {given.file}:{line}: {name}", flush=True)
    finally:
        given.file.write_text(text, encoding="utf-8")
    print(f"{given.file}: {len(found)} mutants, {len(found) - left} killed, {left} left")
    return int(left > 0)


if __name__ == "__main__":
    sys.exit(main())
