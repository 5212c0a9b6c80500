"""The frame of every page: head, styles, data, chart library, script, policy."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from importlib.resources import files
from string import Template

from toolpace.common import __version__
from toolpace.results.report.policy import with_policy


def whole_page(room: str, name: str, title: str, fields: Mapping[str, str], data: str | None = None) -> str:
    """The HTML text of a page whose parts lie in a package: body, script and styles.

    room: the package; in it the body `name`.html, with `fields` (HTML) to fill in beside title and version, the script
    `name`.js, and `name`.css if it has styles of its own.
    data: JSON that the script draws with plotly; None where it draws nothing.
    """
    here = files(room)
    own = here.joinpath(f"{name}.css")
    body = Template(here.joinpath(f"{name}.html").read_text(encoding="utf-8"))
    return framed(
        title,
        body.substitute(fields, title=escape(title), version=escape(__version__)),
        own.read_text(encoding="utf-8") if own.is_file() else "",
        here.joinpath(f"{name}.js").read_text(encoding="utf-8"),
        data,
    )


def framed(title: str, body: str, style: str = "", script: str = "", data: str | None = None) -> str:
    """Any body (HTML) as a page, with the styles of all pages and those of its own, and its policy."""
    here = files("toolpace.results.report")
    scripts = [script] if script else []
    drawn = ""
    if data is not None:
        from plotly.offline import get_plotlyjs

        drawn = f'<script id="data" type="application/json">{data}</script>\n'
        scripts.insert(0, get_plotlyjs())
    page = Template(here.joinpath("shell.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        css=here.joinpath("shell.css").read_text(encoding="utf-8") + style,
        body=body,
        scripts=drawn + "\n".join(f"<script>\n{each}\n</script>" for each in scripts),
    )
    return with_policy(page)
