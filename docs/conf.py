"""How the site is made from the pages here, the docstrings, the examples and the results of the benchmarks.

Everything comes from this repository and from installed packages: no step asks a network, and neither do the pages.
"""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util.fileutil import copy_asset

import toolpace

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "toolpace"
author = "the toolpace developers"
copyright = f"2026, {author}"
release = version = toolpace.__version__

extensions = [
    "docstrings",
    "cyclopts.ext.sphinx",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["pictures"]
nitpicky = True
# Names of other projects: their inventories would have to be fetched.
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|npt|os|pathlib|collections|typing|datetime)\b.*"),
    ("py:.*", r"Floats|Ints|Bools|ArrayLike|npt\.ArrayLike|PathLike|Callable|Sequence|Mapping|BSpline|PPoly|Client"),
    ("py:.*", r"toolpace\.(common\.workers\.(R|CallersProgress)|kernels\..*)"),
    ("py:.*", r"toolpace\.programs\.reading\.controllers\.controller\.Option"),
]
default_role = "code"
smartquotes = False  # primes are derivatives

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "substitution"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_type_aliases = {
    name: name for name in ("Floats", "Ints", "Bools", "npt.ArrayLike", "Machine")
}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

sphinx_gallery_conf = {
    "examples_dirs": ["../examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r".*\.py",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "capture_repr": (),
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "abort_on_example_error": True,
}

# A page of an example that is gone would stay in the gallery.
for page in (HERE / "gallery").glob("[0-9]*.rst"):
    if not (HERE.parent / "examples" / f"{page.stem}.py").exists():
        page.unlink()

# Each result of a benchmark is a page; one that is gone would stay.
RESULTS = HERE.parent / "benchmarks" / "results"
for page in (HERE / "benchmarks").glob("*.md"):
    if page.stem != "index":
        page.unlink()
for result in RESULTS.glob("*.md"):
    text = f"```{{include}} ../../benchmarks/results/{result.name}\n:relative-images:\n```\n"
    (HERE / "benchmarks" / result.name).write_text(text, encoding="utf-8")

html_theme = "pydata_sphinx_theme"
html_title = "toolpace"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "logo": {"text": "toolpace"},
    "navigation_with_keys": False,
    "show_nav_level": 1,
    "show_prev_next": True,
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "tango",
    "pygments_dark_style": "monokai",
}
html_sidebars = {"index": [], "commands": [], "changelog": []}

# Formulas are set by MathJax, from files of the site itself: by default it would come from a network.
mathjax_path = "mathjax/tex-chtml.js"


def copy_mathjax(app: Sphinx, error: Exception | None) -> None:
    """MathJax with its fonts, from an installed package: the part of it that HTML from TeX needs."""
    spec = importlib.util.find_spec("sphinx-mathjax-offline")
    if error is not None or app.builder.format != "html" or spec is None or spec.origin is None:
        return
    source, target = Path(spec.origin).parent / "static" / "mathjax", Path(app.outdir) / "_static" / "mathjax"
    copy_asset(source / "tex-chtml.js", target)
    copy_asset(source / "output" / "chtml", target / "output" / "chtml")


def links_within_the_site(app: Sphinx, page: str, text: list[str]) -> None:
    """Pages name results by their places in the repository; here these are pages of the site."""
    up = "../" * page.count("/")
    text[0] = re.sub(r"\]\((?:\.\./)+benchmarks/results/(?=[\w-]+\.md)", f"]({up}benchmarks/", text[0])


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("build-finished", copy_mathjax)
    app.connect("source-read", links_within_the_site)
    return {"parallel_read_safe": True}
