"""The content security policy of pages.

A content security policy in the page itself. Scripts and style sheets run where their checksums are those of the ones
written here; whatever found its way in by the name of a program does not. There is no network.
"""

from __future__ import annotations

import base64
import hashlib
import re

_INLINE = re.compile(r"<(script|style)((?: [^>]*)?)>(.*?)</\1>", re.DOTALL)
_HEAD = '<meta charset="utf-8">'
_EMPTY = ""
"""plotly makes an empty style sheet and puts its rules into it one by one."""
_SHEET = re.compile(r'getElementById\("([0-9a-f]{64})"\)')
"""What plotly looks for before it adds its style sheet of maps, which would be refused, with a word in the console: an
empty sheet of that name is there already."""


def with_policy(page: str) -> str:
    """The page with a policy for all that stands in it, right behind the declaration of its letters."""
    held: dict[str, list[str]] = {"script": [], "style": [checksum(_EMPTY)]}
    for kind, attributes, text in _INLINE.findall(page):
        # Data is nothing that runs.
        if "json" not in attributes:
            held[kind].append(checksum(text))
    scripts, styles = (" ".join(dict.fromkeys(held[kind])) for kind in ("script", "style"))
    # Widths and colours of bars are attributes of their elements, and so is much of what plotly draws.
    policy = (
        f"default-src 'none'; script-src {scripts}; style-src-elem {styles}; style-src-attr 'unsafe-inline'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    before, found, behind = page.partition(_HEAD)
    if not found:
        raise ValueError(f"a page without {_HEAD}")
    sheets = "".join(f'\n<style id="{each}"></style>' for each in dict.fromkeys(_SHEET.findall(behind)))
    return f'{before}{found}\n<meta http-equiv="Content-Security-Policy" content="{policy}">{sheets}{behind}'


def checksum(text: str) -> str:
    """A text as a policy names it; a browser reads every line end as a line feed."""
    digest = hashlib.sha256(text.replace("\r\n", "\n").replace("\r", "\n").encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
