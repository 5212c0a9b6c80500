"""The app of a folder with its tasks in this process, and requests to it as its page sends them."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import pytest

from toolpace.app.project import Project
from toolpace.app.server import application
from toolpace.app.service import Service
from toolpace.app.worker import ThisProcess, Worker

PORT, TOKEN = 8765, "the-key-of-this-start"
HOST = f"127.0.0.1:{PORT}"
HERE = f"http://{HOST}"
POCKET = """G21 G90 G17 G94
G43.4 H1
G0 X0 Y0 Z30 A0 C0
G1 Z0 F1500
G1 X20 Y0
G1 X20 Y15 A5 C10
G1 X0 Y0 A0 C0
G0 Z30
M2
"""
"""For LinuxCNC."""
KLARTEXT = """BEGIN PGM POCKET MM
TOOL CALL 1 Z S8000
L X+0 Y+0 Z+30 R0 FMAX
M128
L Z+0 F1500
L X+20 Y+0
L X+20 Y+15 A+5 C+10
L X+0 Y+0 A+0 C+0
M129
L Z+30 FMAX
M30
END PGM POCKET MM
"""
REFUSED = """G17 G90 G71 G94
T1 D1
M6
S8000 M3
TRAORI
G0 X0 Y0 Z30 A0 C0
G1 Z0 F1500
G1 X20 Y0
G41 G1 X20 Y15 A5 C10
G1 X0 Y0 A0 C0
G40 G0 Z30
TRAFOOF
M30
"""
"""For Sinumerik: the radius of its tool is not known; `--compensation program` cures it."""


@contextmanager
def service_of(root: Path, jobs: Worker | None = None, aside: Worker | None = None) -> Iterator[Service]:
    """The service of a folder, as it is when the app is started there."""
    project = Project(root)
    project.load()
    (project.plans / ".toolpace-batch").write_text("this batch", encoding="ascii")
    service = Service(project, jobs or ThisProcess(root), aside or ThisProcess(root))
    try:
        yield service
    finally:
        service.stop()


@dataclass(frozen=True)
class Answer:
    """What came back."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def text(self) -> str:
        return self.body.decode()

    def json(self) -> Any:
        return json.loads(self.body)


def asked(
    app: Any, method: str, target: str, headers: Mapping[str, str] | None = None, body: Iterable[bytes] = ()
) -> Answer:
    """The answer to a request as it comes from the wire: the target as it stands, a body in pieces."""
    path, _, query = target.partition("?")
    scope = {
        "type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "method": method, "scheme": "http",
        "path": unquote(path), "raw_path": path.encode(), "query_string": query.encode(), "root_path": "",
        "headers": [(name.encode(), value.encode()) for name, value in {"host": HOST, **(headers or {})}.items()],
        "client": ("127.0.0.1", 50000), "server": ("127.0.0.1", PORT),
    }  # fmt: skip
    pieces = [*body, b""]
    started: dict[str, Any] = {}
    came: list[bytes] = []

    async def receive() -> dict[str, Any]:
        if not pieces:
            await asyncio.Event().wait()  # it stays connected
        return {"type": "http.request", "body": pieces.pop(0), "more_body": bool(pieces)}

    async def send(message: dict[str, Any]) -> None:
        if message["type"] == "http.response.start":
            started.update(message)
        else:
            came.append(message.get("body", b""))

    asyncio.run(app(scope, receive, send))
    named = {name.decode(): value.decode() for name, value in started["headers"]}
    return Answer(started["status"], named, b"".join(came))


@dataclass
class AppClient:
    """A browser that is let in."""

    service: Service
    app: Any

    def ask(self, method: str, target: str, body: bytes | Iterable[bytes] = b"", **headers: str) -> Answer:
        """The answer to a request with the key."""
        named = {"x-toolpace-token": TOKEN} | {name.replace("_", "-"): value for name, value in headers.items()}
        return asked(self.app, method, target, named, [body] if isinstance(body, bytes) else body)

    def done(self, method: str, target: str, body: Any = None) -> Any:
        """What came of a request that is granted."""
        answer = self.ask(method, target, b"" if body is None else json.dumps(body).encode())
        assert answer.status == 200, answer.text
        return answer.json()

    def upload(self, name: str, text: str | bytes, part: str = "") -> str:
        """The id of the part."""
        content = text.encode() if isinstance(text, str) else text
        answer = self.ask("POST", f"/api/files?name={quote(name)}&part={part}", content)
        assert answer.status == 200, answer.text
        return answer.json()["part"]

    def start(self, part: str, **request: str | bool) -> str:
        """The id of a job."""
        return self.done("POST", f"/api/parts/{part}/jobs", {"machine": "xyzac-trunnion", **request})["job"]

    def state(self) -> dict[str, Any]:
        """What the page shows."""
        return self.done("GET", "/api/state")

    def part(self, part: str) -> dict[str, Any]:
        """A part, inspected."""
        return self.wait(lambda: next(p for p in self.state()["parts"] if p["id"] == part and p["inspection"]))

    def job(self, job: str) -> dict[str, Any]:
        """A job, ended."""
        ended = ("ended", "stopped")
        return self.wait(lambda: next(j for j in self.state()["jobs"] if j["id"] == job and j["state"] in ended))

    def wait(self, found: Callable[[], Any], seconds: float = 60.0) -> Any:
        """What is found sooner or later."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            try:
                return found()
            except StopIteration:
                time.sleep(0.02)
        raise AssertionError(f"never there: {self.state()['jobs']}")


@contextmanager
def app_client(root: Path, jobs: Worker | None = None, largest: int = 10_000_000) -> Iterator[AppClient]:
    """The app of a folder, and one who has its key."""
    pytest.importorskip("starlette", exc_type=ImportError)
    with service_of(root, jobs) as service:
        yield AppClient(service, application(service, PORT, TOKEN, largest))
