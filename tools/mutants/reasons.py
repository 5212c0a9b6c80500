"""Why changes that no test notices do no harm: by file, code and kind of change, and by the line where that is told."""

from __future__ import annotations

import tomllib
from pathlib import Path

FILE = Path(__file__).with_name("harmless.toml")


def reason_of(file: str, code: str, name: str, line: str) -> str:
    """The reason, empty where none is known; `line` is the text of the line of the change."""
    for entry in tomllib.loads(FILE.read_text(encoding="utf-8")).get("change", []):
        what = entry["file"], entry["code"], entry.get("name", name), entry.get("at", line.strip())
        if what == (file, code, name, line.strip()):
            return str(entry["reason"])
    return ""
