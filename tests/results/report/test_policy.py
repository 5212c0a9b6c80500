"""The content security policy of pages: what toolpace wrote runs, what was put in does not, and nothing is fetched."""

from __future__ import annotations

import re

import pytest

from tests.support import motions
from tests.support.report_pages import opened
from toolpace.results.report import write_report
from toolpace.results.report.shell import checksum, framed, with_policy

INTRUDER = (
    "<script>document.title = 'intruder 1'</script><img src='data:,' onerror=\"document.title = 'intruder 2'\">"
    "<a id='link' href=\"javascript:document.title = 'intruder 3'\">link</a>"
)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    trajectory = motions.Trajectory()
    write_report(file, trajectory, trajectory.sample(), motions.program())
    return file


def policy_of(text):
    found = re.findall(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', text)
    assert len(found) == 1
    return dict(rule.split(" ", 1) for rule in found[0].split("; "))


def test_nothing_is_allowed_but_what_the_page_holds(page):
    text = page.read_text(encoding="utf-8")
    policy = policy_of(text)
    assert policy["default-src"] == "'none'" == policy["base-uri"] == policy["form-action"]
    assert set(policy) == {
        "default-src", "script-src", "style-src-elem", "style-src-attr", "img-src", "base-uri", "form-action"
    }  # fmt: skip
    assert all(source.startswith("'sha256-") for source in policy["script-src"].split())
    assert all(source.startswith("'sha256-") for source in policy["style-src-elem"].split())
    assert policy["img-src"] == "data: blob:"
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    assert len(scripts) == 2 and {checksum(script) for script in scripts} == set(policy["script-src"].split())
    # The policy rules what stands behind it: nothing that runs, or is fetched, stands before.
    assert not re.search("<(script|style|link|img)", text[: text.index("Content-Security-Policy")])


def test_checksums_are_those_of_the_standard():
    """The example of CSP level 2, section 4.2.5, and the empty string."""
    assert checksum("alert('Hello, world.');") == "'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='"
    assert checksum("") == "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
    assert checksum("a\r\nb\rc") == checksum("a\nb\nc")


def test_data_is_no_script_and_a_page_without_a_head_is_none():
    text = '<meta charset="utf-8"><script type="application/json">{}</script><script>1</script>'
    assert policy_of(with_policy(text))["script-src"] == checksum("1")
    with pytest.raises(ValueError, match="a page without"):
        with_policy("<script>1</script>")


def test_every_page_can_be_written_whatever_a_file_is_called():
    text = framed("part\udcff.nc", "<h1>part\udcff.nc</h1>")
    assert text.encode() and text.count("part\\udcff.nc") == 2


@pytest.mark.browser
@pytest.mark.sweep
def test_a_browser_draws_the_page_and_lets_nobody_in(page, tmp_path):
    """A script, a handler and a link that were put in do nothing, and what the page holds misses nothing."""
    ready = "<script>setTimeout(() => document.getElementById('link').click(), 100)</script>"
    changed = tmp_path / "changed.html"
    text = page.read_text(encoding="utf-8")
    changed.write_text(text.replace("</main>", INTRUDER + ready + "</main>"), encoding="utf-8")
    with opened(page) as found:
        assert found.problems == []
    with opened(changed) as found:
        found.run("document.getElementById('link').click()")
        found.page.wait_for_timeout(300)
        assert not found.page.title().startswith("intruder")
        assert len([line for line in found.problems if "Content Security Policy" in line and "script-src" in line]) >= 2
        assert all("Content Security Policy" in line for line in found.problems)
