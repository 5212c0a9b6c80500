"""Small changes of a module: comparisons exchanged, conditions negated, + and - and * and / exchanged, min and max
exchanged, constants doubled (and 0 made 1), statements removed, results of functions replaced by None."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from typing import NamedTuple

COMPARISONS = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
PAIRS = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "argmax": "argmin",
         "any": "all", "all": "any"}  # fmt: skip
STATEMENTS = (ast.Assign, ast.AugAssign, ast.Raise, ast.Expr, ast.Continue, ast.Break)


class Change(NamedTuple):
    """One change of a module."""

    line: int
    index: int
    """Of the node among those of the module that have a line."""
    name: str
    """What is done to it."""
    code: str
    """The node as it is."""


def all_changes(text: str) -> Iterator[Change]:
    """All changes of a module, in the order of its text; docstrings and annotations stay."""
    tree = ast.parse(text)
    quiet = {id(n) for each in ast.walk(tree) for n in _annotations(each)}
    for index, node in enumerate(_placed(tree)):
        if id(node) in quiet:
            continue
        for name in names_of(node):
            yield Change(node.lineno, index, name, ast.unparse(node).splitlines()[0][:70])


def changed_text(text: str, change: Change) -> str:
    """The module with a change."""
    tree = ast.parse(text)
    apply(tree, _placed(tree)[change.index], change.name)
    return ast.unparse(ast.fix_missing_locations(tree))


def _placed(tree: ast.Module) -> list[ast.AST]:
    return [node for node in ast.walk(tree) if hasattr(node, "lineno") and not isinstance(node, ast.alias)]


def _annotations(node: ast.AST) -> Iterator[ast.AST]:
    """Nodes that Python never looks at: all modules postpone their annotations."""
    for field in ("annotation", "returns"):
        found = getattr(node, field, None)
        if isinstance(found, ast.AST):
            yield from ast.walk(found)


def names_of(node: ast.AST) -> list[str]:
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
