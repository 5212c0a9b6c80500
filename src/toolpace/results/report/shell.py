"""The frame of every page: head, styles, data, chart library, script, and a content security policy.

Scripts and style sheets run where their checksums are those of the ones written here; whatever found its way in by the
name of a program does not. There is no network.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from importlib.resources.abc import Traversable
from string import Template

from toolpace.common import __version__

_INLINE = re.compile(r"<(script|style)((?: [^>]*)?)>(.*?)</\1>", re.DOTALL)
_HEAD = '<meta charset="utf-8">'
_EMPTY = ""
"""plotly makes an empty style sheet and puts its rules into it one by one."""
_SHEET = re.compile(r'getElementById\("([0-9a-f]{64})"\)')
"""What plotly looks for before it adds its style sheet of maps, which would be refused, with a word in the console: an
empty sheet of that name is there already."""


def whole_page(
    room: str, name: str, title: str, fields: Mapping[str, str], data: str | None = None, scripts: Sequence[str] = ()
) -> str:
    """The HTML text of a page whose parts lie in a package: body, script and styles.

    room: the package; in it the body `name`.html, with `fields` (HTML) to fill in beside title and version, the script
    `name`.js, and `name`.css if it has styles of its own.
    data: JSON that the script draws; None where it draws nothing.
    scripts: files in the package that make up the script, which draws with three.js; none: `name`.js, with plotly.
    """
    here = files(room)
    own = here.joinpath(f"{name}.css")
    body = Template(here.joinpath(f"{name}.html").read_text(encoding="utf-8"))
    return framed(
        title,
        body.substitute(fields, title=escape(title), version=escape(__version__)),
        own.read_text(encoding="utf-8") if own.is_file() else "",
        _joined(here, scripts) if scripts else here.joinpath(f"{name}.js").read_text(encoding="utf-8"),
        data,
        three_js() if scripts else None,
    )


def three_js() -> str:
    """The library of pages that show bodies, as tools/vendor.py built it."""
    return files("toolpace.results.report").joinpath("vendor/three.min.js").read_text(encoding="utf-8")


def _joined(folder: Traversable, names: Sequence[str]) -> str:
    """Files as one script, whose names nobody else sees."""
    texts = "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)
    return f'(() => {{\n"use strict";\n{texts}\n}})();'


def framed(
    title: str, body: str, style: str = "", script: str = "", data: str | None = None, library: str | None = None
) -> str:
    """Any body (HTML) as a page, with the styles of all pages and those of its own, and its policy.

    library: what the script of data stands on; None: plotly.
    """
    here = files("toolpace.results.report")
    scripts = [script] if script else []
    drawn = ""
    if data is not None:
        drawn = f'<script id="data" type="application/json">{data}</script>\n'
        scripts.insert(0, _plotly() if library is None else library)
    page = Template(here.joinpath("shell.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        css=here.joinpath("shell.css").read_text(encoding="utf-8") + style,
        body=body,
        scripts=drawn + "\n".join(f"<script>\n{each}\n</script>" for each in scripts),
    )
    # the system hands over a file's name in another encoding as halves of characters, which no file can hold
    return with_policy(page.encode("utf-8", "backslashreplace").decode("utf-8"))


def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())


def cards(figures: Iterable[tuple[str, str, str, str]], between: str = "\n") -> str:
    """Figures as cards (HTML): label, value, note and class of each."""
    return between.join(
        f'<div class="card {kind}"><div class="label">{escape(label)}</div><div class="value">{escape(value)}</div>'
        f'<div class="note">{escape(note)}</div></div>'
        for label, value, note, kind in figures
    )


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
