"""The checksum file by which a folder is known as written by toolpace and unchanged since.

Its main file (plan.json, study.json, export.json, cut.json and others) ends with a seal: the checksums of all other
files, and one of itself, taken with zeros in place of that checksum. A folder that holds anything else, or anything
changed, is not toolpace's to replace.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

MAIN = ("plan.json", "study.json", "export.json", "time.json", "inspect.json", "setup.json", "cut.json")
"""Files that can bear a seal."""
KEY = "seal"
_OPEN = "0" * 64
"""Stands in the file while its checksum is taken."""
MOST_TRIES = 20
"""At a folder that others replace, before it is said to be changed."""
LONGEST = 1 << 26
"""Most bytes of a file that bears a seal; more is none of ours."""


def write_seal(folder: Path, name: str) -> None:
    """End the JSON object in `folder / name` with a seal over all files of the folder."""
    with os.scandir(folder) as entries:
        files = {entry.name: checksum(Path(entry.path)) for entry in sorted(entries, key=_name)}
    files.pop(name)
    seal = {"files": files, "sha256": _OPEN}
    body = (folder / name).read_text(encoding="utf-8").rstrip().removesuffix("}").rstrip()
    text = f'{body},\n  "{KEY}": {json.dumps(seal)}\n}}\n'
    own = hashlib.sha256(text.encode()).hexdigest()
    (folder / name).write_bytes(text.replace(_OPEN, own).encode())


def read_seal(folder: Path) -> tuple[str, dict[str, str]] | None:
    """The name of the file that bears the folder's seal, and the checksums in it; None where none is whole."""
    for name in MAIN:
        try:
            if (folder / name).stat().st_size > LONGEST:
                continue
            data = (folder / name).read_bytes()
            seal = json.loads(data)[KEY]
            files, own = seal["files"], seal["sha256"]
            whole = isinstance(own, str) and isinstance(files, dict)
            if whole and hashlib.sha256(data.replace(own.encode(), _OPEN.encode())).hexdigest() == own:
                return name, files
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            continue
    return None


def foreign(folder: Path) -> str:
    """What in a folder is not as toolpace wrote it, in words; empty where all of it is, or nothing is there.

    Another run may put its folder in the place of this one meanwhile: then it is looked at anew. Raises OSError where
    the folder cannot be read.
    """
    for _ in range(MOST_TRIES):
        seal = read_seal(folder)
        found = _beside(folder, seal)
        if not found or read_seal(folder) == seal:
            break
    return found


def _beside(folder: Path, seal: tuple[str, dict[str, str]] | None) -> str:
    """What in a folder its seal does not speak of, in words."""
    with os.scandir(folder) as found:
        entries = sorted(found, key=_name)
    if not entries:
        return ""
    if seal is None:
        main = next((entry.name for entry in entries if entry.name in MAIN), "")
        if main:
            return f"its {main} is not as toolpace wrote it"
        return f"it holds {entries[0].name}, and no plan.json of toolpace"
    name, files = seal
    for entry in entries:
        if entry.name == name:
            continue
        if entry.name not in files:
            return f"it holds {entry.name}, which toolpace did not write"
        if not entry.is_file(follow_symlinks=False) or checksum(Path(entry.path)) != files[entry.name]:
            return f"its {entry.name} was changed after toolpace wrote it"
    return ""


def sealed_files(folder: Path) -> tuple[str, ...]:
    """Names of the files that toolpace wrote into a folder, beside the one that bears the seal; none where it is
    broken."""
    seal = read_seal(folder)
    return tuple(seal[1]) if seal is not None else ()


def changed(folder: Path) -> str:
    """Which file of a folder was changed after toolpace wrote it, in words; empty where none was.

    A file that is missing, or that toolpace did not write, is no change. Raises OSError where one cannot be read.
    """
    seal = read_seal(folder)
    if seal is None:
        return "the seal at the end of plan.json is missing, or not of the file as it is"
    for name, right in seal[1].items():
        if (folder / name).is_file() and checksum(folder / name) != right:
            return f"{name} was changed after toolpace wrote it"
    return ""


def checksum(file: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _name(entry: os.DirEntry[str]) -> str:
    return entry.name
