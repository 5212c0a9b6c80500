"""A contract for import-linter: what a package may import, everything else of the project being forbidden.

import-linter's own `forbidden` names what may not be imported, so a new room is open to all until somebody thinks of
it; here a new room is closed until it is named. Direct imports are judged, those for type checking too; with
`reach = true` also all that is imported by what is imported.
"""

from __future__ import annotations

from grimp import ImportGraph
from importlinter.application import output
from importlinter.domain import fields
from importlinter.domain.contract import Contract, ContractCheck

Found = list[tuple[str, str, tuple[int, ...]]]
"""Importer, what it imports, and the lines."""


class WhitelistContract(Contract):
    """Imports of `source_modules` (packages) end in themselves or in `allowed_modules` (packages or modules).

    within: only imports that end in this package are judged; the whole project unless given.
    reach: whether what is imported is judged like the sources.
    """

    type_name = "whitelist"

    source_modules = fields.ListField(subfield=fields.StringField())
    allowed_modules = fields.ListField(subfield=fields.StringField(), required=False, default=[])
    within = fields.StringField(required=False, default="")
    reach = fields.BooleanField(required=False, default=False)

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        """Every import that is not allowed, by importer."""
        missing = [name for name in (*self.source_modules, *self.allowed_modules) if name not in graph.modules]
        if missing:
            raise ValueError(f"contract '{self.name}': no such module: {', '.join(missing)}")
        found: Found = []
        for source in self.source_modules:
            # rooms that are sources together are not open to each other
            allowed = (source, *self.allowed_modules)
            todo = sorted({source, *graph.find_descendants(source)})
            seen = set(todo)
            while todo:
                importer = todo.pop()
                for imported in sorted(graph.find_modules_directly_imported_by(importer)):
                    if not _inside(imported, allowed):
                        if not self.within or _inside(imported, (self.within,)):
                            found.append((importer, imported, _lines(graph, importer, imported)))
                    elif self.reach and imported not in seen:
                        seen.add(imported)
                        todo.append(imported)
        return ContractCheck(kept=not found, metadata={"found": sorted(found)})

    def render_broken_contract(self, check: ContractCheck) -> None:
        """One line an import."""
        for importer, imported, lines in check.metadata["found"]:
            where = ", ".join(f"l.{line}" for line in lines)
            output.print_error(f"{importer} imports {imported} ({where}), which is not on its whitelist")


def _inside(module: str, packages: tuple[str, ...]) -> bool:
    return any(module == package or module.startswith(f"{package}.") for package in packages)


def _lines(graph: ImportGraph, importer: str, imported: str) -> tuple[int, ...]:
    details = graph.get_import_details(importer=importer, imported=imported)
    return tuple(sorted(detail["line_number"] for detail in details))
