"""Who is let into the app, and what is refused."""

from __future__ import annotations

import asyncio
from urllib.parse import quote

import pytest

from tests.support.app_client import HERE, HOST, POCKET, PORT, TOKEN, Answer, AppClient, app_client, asked
from toolpace.app.project import checked_name
from toolpace.common.errors import UsageError

SMALL = 2000
"""Largest upload that these tests allow [bytes]."""
OUT_OF_THE_FOLDER = (
    "../part.ngc", "..\\part.ngc", "/etc/part.ngc", "C:part.ngc", "a/b.ngc", "part\0.ngc", "part\n.ngc", "..", ".",
    "", ".hidden.ngc", "part.ngc ", "x" * 201, "é" * 101, "\x1b[31m.ngc", "part.a\0b",
)  # fmt: skip


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    with app_client(tmp_path_factory.mktemp("app"), largest=SMALL) as client:
        yield client


def stranger(app: AppClient, target: str, **headers: str) -> Answer:
    """The answer to one who has no key."""
    return asked(app.app, "GET", target, {name.replace("_", "-"): value for name, value in headers.items()})


def files_of(app: AppClient) -> list[str]:
    return sorted(str(path) for path in app.service.project.root.rglob("*"))


@pytest.mark.parametrize("path", ["/", "/app.js", "/api/state", "/report/0", "/nothing", "/?token=wrong", "/?token="])
def test_without_the_key_nothing_is_told(app, path):
    for headers in ({}, {"cookie": f"toolpace-{PORT}=wrong"}, {"x_toolpace_token": "wrong"}, {"cookie": "=;=\xff"}):
        answer = stranger(app, path, **headers)
        assert answer.status == 401 and "address that `toolpace app` printed" in answer.text


def test_the_address_that_is_printed_lets_in_by_a_cookie(app):
    answer = stranger(app, f"/?token={TOKEN}")
    assert answer.status == 303 and answer.headers["location"] == "/"
    cookie, _, how = answer.headers["set-cookie"].partition("; ")
    assert how == "HttpOnly; SameSite=Strict; Path=/"
    assert stranger(app, "/", cookie=cookie).status == 200 and stranger(app, "/api/state", cookie=cookie).status == 200
    # in an address the key is for the page alone: no link to anything else carries it
    assert stranger(app, f"/api/state?token={TOKEN}").status == 401


@pytest.mark.parametrize("host", ["toolpace.example", "127.0.0.1", f"127.0.0.1:{PORT + 1}", f"evil.example:{PORT}", ""])
def test_another_host_is_refused_with_the_key(app, host):
    assert app.ask("GET", "/api/state", host=host).status == 421
    assert stranger(app, f"/?token={TOKEN}", host=host).status == 421


@pytest.mark.parametrize(
    "headers",
    [{"origin": "http://evil.example"}, {"origin": "null"}, {"origin": f"https://127.0.0.1:{PORT}"},
     {"origin": f"http://127.0.0.1:{PORT + 1}"}, {"sec_fetch_site": "cross-site"}, {"sec_fetch_site": "same-site"}],
)  # fmt: skip
def test_another_site_is_refused_with_the_key(app, headers):
    before = files_of(app)
    assert app.ask("GET", "/api/state", **headers).status == 403
    assert app.ask("POST", "/api/files?name=part.ngc", b"G0 X0", **headers).status == 403 and files_of(app) == before
    assert app.ask("GET", "/api/state", origin=HERE, sec_fetch_site="same-origin").status == 200


def test_a_socket_is_not_opened(app):
    sent: list[dict[str, object]] = []

    async def send(message: dict[str, object]) -> None:
        sent.append(message)

    scope = {"type": "websocket", "path": "/", "headers": [(b"host", HOST.encode())], "query_string": b""}
    asyncio.run(app.app(scope, None, send))
    assert sent == [{"type": "websocket.close", "code": 1008}]


@pytest.mark.parametrize("name", OUT_OF_THE_FOLDER)
def test_a_name_that_leads_elsewhere_is_refused(app, name):
    before = files_of(app)
    answer = app.ask("POST", f"/api/files?name={quote(name)}", POCKET.encode())
    assert answer.status == 400 and "rename" in answer.text and files_of(app) == before
    with pytest.raises(UsageError):
        checked_name(name)


@pytest.mark.parametrize("name", ["part.ngc", "x" * 200, "Gehäuse 3 (neu).h", "..part.ngc.bak"[2:], "日本.nc"])
def test_a_name_of_a_file_is_taken(name):
    assert checked_name(name) == name


@pytest.mark.parametrize(
    "path",
    ["/report/../../../../etc/passwd", "/report/..%2f..%2fetc%2fpasswd", "/program/%2e%2e", "/compare/..%2f..%2fx",
     "/api/compare/../state", "/..%2fpyproject.toml", "/page.html", "/report/%00", "/api/parts/..%2f/sheet",
     "/report/" + "a" * 1500],
)  # fmt: skip
def test_a_path_that_leads_elsewhere_finds_nothing(app, path):
    answer = app.ask("GET", path)
    assert answer.status == 404 and "root:" not in answer.text and "\n" not in answer.text


def test_too_long_an_address_is_refused(app):
    assert app.ask("GET", "/report/" + "a" * 3000).status == 414


def test_too_large_an_upload_is_refused_and_leaves_nothing(app):
    before = files_of(app)
    target = "/api/files?name=part.ngc"
    told = app.ask("POST", target, b"", content_length=str(SMALL + 1))
    pieces = app.ask("POST", target, [b"x" * 500] * 9)
    lied = app.ask("POST", target, [b"x" * 500] * 9, content_length="7")
    assert (told.status, pieces.status, lied.status) == (413, 413, 413)
    assert "MB at most are taken" in told.text and files_of(app) == before
    assert app.ask("PUT", "/api/parts/0/sheet", [b"x" * (1 << 20)] * 3).status == 413


@pytest.mark.parametrize(
    "body",
    [b"", b"{", b"[]", b"null", b'{"machine": 3}', b'{"machine": "no-such-machine"}', b'{"machine": "../x"}',
     b'{"machine": "xyzac-trunnion", "out": "/tmp/x"}', b'{"machine": "xyzac-trunnion", "tip_tolerance": "-1mm"}',
     b'{"machine": "xyzac-trunnion", "feeds": "fast"}', b"[" * 100_000, b'{"machine": "\\ud800"}', b"\xff\xfe"],
)  # fmt: skip
def test_a_request_that_makes_no_sense_is_one_line(app, body):
    part = app.upload("part.ngc", POCKET)
    answer = app.ask("POST", f"/api/parts/{part}/jobs", body)
    assert answer.status == 400 and answer.text and "\n" not in answer.text and "Traceback" not in answer.text
    app.done("DELETE", f"/api/parts/{part}")


@pytest.mark.parametrize("body", [b'{"controller": "/etc/passwd"}', b'{"controller": "../x.toml"}', b'{"lenient": 3}'])
def test_how_a_program_is_read_names_no_file(app, body):
    part = app.upload("part.ngc", POCKET)
    assert app.ask("PUT", f"/api/parts/{part}/reading", body).status == 400
    app.done("DELETE", f"/api/parts/{part}")


def test_a_fault_is_one_line_and_no_traceback(app, monkeypatch):
    def fails():
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(app.service, "state", fails)
    answer = app.ask("GET", "/api/state")
    assert (answer.status, answer.text) == (
        500, "a fault in toolpace itself, ZeroDivisionError: division by zero"
    )  # fmt: skip


def test_every_answer_keeps_the_page_in_place(app):
    for answer in (app.ask("GET", "/"), app.ask("GET", "/nothing"), stranger(app, "/")):
        headers = answer.headers
        assert "default-src 'none'" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff" and headers["cache-control"] == "no-store"
        assert headers["referrer-policy"] == "no-referrer"
