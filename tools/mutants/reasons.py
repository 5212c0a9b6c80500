"""Why changes that no test notices do no harm: by file, code and kind of change."""

from __future__ import annotations

import tomllib
from pathlib import Path

FILE = Path(__file__).with_name("harmless.toml")


def reason_of(file: str, code: str, name: str) -> str:
    """The reason, empty where none is known."""
    for entry in tomllib.loads(FILE.read_text(encoding="utf-8")).get("change", []):
        if entry["file"] == file and entry["code"] == code and entry.get("name", name) == name:
            return str(entry["reason"])
    return ""
