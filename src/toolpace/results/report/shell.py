"""The frame of every page: head, styles, data, scripts, and a content security policy.

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
THEME_BUTTON = (
    '<button type="button" class="plain" data-do="theme" title="Dark or light" aria-label="Dark or light">'
    '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 2v10A5 5 0 0 1 8 3z"/>'
    "</svg></button>"
)
"""Switches the colours of a page."""
PARTS = ("transport", "camera", "space", "zoom", "curves")
"""Of players: buttons of playing, those of the camera, the 3-D view, buttons of the time line, and its drawing."""


def whole_page(
    room: str,
    name: str,
    title: str,
    fields: Mapping[str, str],
    data: str | None = None,
    scripts: Sequence[str] = (),
    live: bool = False,
) -> str:
    """The HTML text of a page whose parts lie in a package: body, script and styles.

    room: the package; in it the body `name`.html, with `fields` (HTML) to fill in beside title, version, the button of
    dark and light (`theme`) and the PARTS of a player; and `name`.js and `name`.css if it has a script and styles of
    its own.
    data: JSON that the script draws; None where it draws nothing.
    scripts: names of files in report/player/ or in the package that the script stands on, in order; `scene` draws with
    three.js, which is then there too.
    live: whether the page may ask the server that it is from for more.
    """
    here, parts = files(room), files("toolpace.results.report").joinpath("player")
    body = Template(_text(here.joinpath(f"{name}.html")))
    own = [file for file in (here.joinpath(f"{name}.js"),) if file.is_file()]
    style = "".join(
        _text(file)
        for file in ([parts.joinpath("player.css")] if scripts else []) + [here.joinpath(f"{name}.css")]
        if file.is_file()
    )
    return framed(
        title,
        body.substitute(
            fields, title=escape(title), version=escape(__version__), theme=THEME_BUTTON, **player_parts()
        ),
        style,
        _joined([*(_script(each, parts, here) for each in ("theme", *scripts)), *own]),
        data,
        three_js() if "scene" in scripts else "",
        live,
    )


def player_parts() -> dict[str, str]:
    """The PARTS of a player (HTML), by name."""
    folder = files("toolpace.results.report").joinpath("player")
    return {name: _text(folder.joinpath(f"{name}.html")).rstrip("\n") for name in PARTS}


def motion_section(duration: float, below: str = "") -> str:
    """The player of a motion (HTML) of so many seconds: its view, the program and lists, the time line, and what stands
    `below` that (HTML)."""
    section = Template(_text(files("toolpace.results.report").joinpath("player/motion.html")))
    return section.substitute(player_parts(), duration=f"{duration:.6g}", below=below)


def three_js() -> str:
    """The library of pages that show bodies, as tools/vendor.py built it."""
    return _text(files("toolpace.results.report").joinpath("vendor/three.min.js"))


def _text(file: Traversable) -> str:
    return file.read_text(encoding="utf-8")


def _script(name: str, *folders: Traversable) -> Traversable:
    """The file of that name in the first folder that has it."""
    return next(file for folder in folders if (file := folder.joinpath(f"{name}.js")).is_file())


def _joined(scripts: Sequence[Traversable]) -> str:
    """Files as one script, whose names nobody else sees."""
    texts = "\n".join(map(_text, scripts))
    return f'(() => {{\n"use strict";\n{texts}\n}})();'


def framed(
    title: str,
    body: str,
    style: str = "",
    script: str = "",
    data: str | None = None,
    library: str = "",
    live: bool = False,
) -> str:
    """Any body (HTML) as a page, with the styles of all pages and those of its own, and its policy.

    script: of its own; without one the button of dark and light works all the same.
    library: a script that it stands on.
    """
    here = files("toolpace.results.report")
    theme = f'(() => {{\n"use strict";\n{_text(here.joinpath("player/theme.js"))}\nwatchTheme();\n}})();'
    scripts = [script or theme]
    drawn = ""
    if data is not None:
        drawn = f'<script id="data" type="application/json">{data}</script>\n'
        scripts = [*filter(None, [library]), *scripts]
    page = Template(_text(here.joinpath("shell.html"))).substitute(
        title=escape(title),
        css=_text(here.joinpath("shell.css")) + style,
        body=body,
        scripts=drawn + "\n".join(f"<script>\n{each}\n</script>" for each in scripts),
    )
    # the system hands over a file's name in another encoding as halves of characters, which no file can hold
    return with_policy(page.encode("utf-8", "backslashreplace").decode("utf-8"), live)


def cards(figures: Iterable[tuple[str, str, str, str]], between: str = "\n") -> str:
    """Figures as cards (HTML): label, value, note and class of each."""
    return between.join(
        f'<div class="card {kind}"><div class="label">{escape(label)}</div><div class="value">{escape(value)}</div>'
        f'<div class="note">{escape(note)}</div></div>'
        for label, value, note, kind in figures
    )


def with_policy(page: str, live: bool = False) -> str:
    """The page with a policy for all that stands in it, right behind the declaration of its letters.

    live: it may ask the server that it is from for more.
    """
    held: dict[str, list[str]] = {"script": [], "style": []}
    for kind, attributes, text in _INLINE.findall(page):
        # Data is nothing that runs.
        if "json" not in attributes:
            held[kind].append(checksum(text))
    scripts, styles = (" ".join(dict.fromkeys(held[kind])) or "'none'" for kind in ("script", "style"))
    # Widths and colours of bars are attributes of their elements.
    policy = (
        f"default-src 'none'; script-src {scripts}; style-src-elem {styles}; style-src-attr 'unsafe-inline'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'" + ("; connect-src 'self'" if live else "")
    )
    before, found, behind = page.partition(_HEAD)
    if not found:
        raise ValueError(f"a page without {_HEAD}")
    return f'{before}{found}\n<meta http-equiv="Content-Security-Policy" content="{policy}">{behind}'


def checksum(text: str) -> str:
    """A text as a policy names it; a browser reads every line end as a line feed."""
    digest = hashlib.sha256(text.replace("\r\n", "\n").replace("\r", "\n").encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
