"""The routes of the app, and its server. Nothing in an address is a path: parts and jobs go by ids that were drawn."""

from __future__ import annotations

import os
import secrets
import socket
import tempfile
from collections.abc import Awaitable, Callable
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from toolpace.app.guard import Guard
from toolpace.app.project import UPLOAD, checked_name
from toolpace.app.records import Reading, Request
from toolpace.app.service import NotFoundError, Service
from toolpace.common.cluster.pool import error_in_words
from toolpace.common.errors import ToolpaceError, UsageError
from toolpace.common.files import free_disk

if TYPE_CHECKING:
    import uvicorn
    from starlette.requests import Request as HttpRequest
    from starlette.responses import Response
    from starlette.types import ASGIApp

CURE = "the app needs starlette and uvicorn: pip install 'toolpace[app]'"
LARGEST_UPLOAD = 256 << 20
"""Bytes of a program or a mesh."""
LARGEST_BODY = 2 << 20
"""Bytes of anything else."""
ROOM = 100e6
"""Bytes that stay free on the disk."""
SANDBOX = "sandbox allow-scripts allow-downloads"
"""Of pages of results: whatever got into one by the name of a program, it is not the app's own origin there."""
ASSETS = {"app.css": "text/css", "app.js": "text/javascript"}
Endpoint = Callable[["HttpRequest"], Awaitable["Response"]]


class Refused(Exception):
    """A request that is answered with a status and a reason."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


def application(service: Service, port: int, token: str, largest: int = LARGEST_UPLOAD) -> ASGIApp:
    """The ASGI application of a service, reached at a port by those who have the token."""
    from starlette.applications import Starlette
    from starlette.routing import Route

    handlers = _Handlers(service, largest)
    table: list[tuple[str, str, Endpoint]] = [
        ("GET", "/", handlers.page),
        ("GET", "/{asset}", handlers.asset),
        ("GET", "/api/state", handlers.state),
        ("POST", "/api/files", handlers.upload),
        ("PUT", "/api/parts/{part}/reading", handlers.set_reading),
        ("GET", "/api/parts/{part}/sheet", handlers.sheet),
        ("PUT", "/api/parts/{part}/sheet", handlers.set_sheet),
        ("POST", "/api/parts/{part}/sheet", handlers.fill_in_sheet),
        ("DELETE", "/api/parts/{part}", handlers.remove_part),
        ("POST", "/api/parts/{part}/jobs", handlers.add_job),
        ("POST", "/api/jobs/{job}/stop", handlers.stop_job),
        ("POST", "/api/jobs/{job}/again", handlers.again),
        ("DELETE", "/api/jobs/{job}", handlers.remove_job),
        ("POST", "/api/compare", handlers.compare),
        ("GET", "/api/compare/{name}", handlers.is_compared),
        ("GET", "/compare/{name}", handlers.comparison),
        ("GET", "/report/{job}", handlers.report),
        ("GET", "/feeds/{job}", handlers.feeds_page),
        ("GET", "/program/{job}", handlers.program),
    ]
    routes = [Route(path, _answered(handler), methods=[method]) for method, path, handler in table]
    return Guard(Starlette(routes=routes), port, token)


def _answered(handler: Endpoint) -> Endpoint:
    """A handler whose errors are answers: one line, and a status that fits."""

    async def answer(request: HttpRequest) -> Response:
        from starlette.requests import ClientDisconnect
        from starlette.responses import PlainTextResponse

        try:
            return await handler(request)
        except Refused as error:
            return PlainTextResponse(str(error), error.status)
        except NotFoundError as error:
            return PlainTextResponse(str(error), 404)
        except ToolpaceError as error:
            return PlainTextResponse(str(error), 400)
        except ClientDisconnect:
            return PlainTextResponse("the upload was broken off", 400)
        except OSError as error:
            return PlainTextResponse(f"the disk does not take it: {(error.strerror or str(error)).lower()}", 507)
        except Exception as error:
            return PlainTextResponse(error_in_words(error), 500)

    return answer


class _Handlers:
    """What is done for each route."""

    def __init__(self, service: Service, largest: int) -> None:
        self.service, self.largest = service, largest

    async def page(self, request: HttpRequest) -> Response:
        from starlette.responses import HTMLResponse

        return HTMLResponse(_text("page.html"))

    async def asset(self, request: HttpRequest) -> Response:
        from starlette.responses import Response

        name = request.path_params["asset"]
        if name not in ASSETS:
            raise Refused(404, "there is nothing here")
        text = _text("elements.js") + _text("page.js")
        if name.endswith(".css"):
            shell = files("toolpace.results.report").joinpath("shell.css").read_text(encoding="utf-8")
            text = shell + _text("page.css")
        return Response(text, media_type=ASSETS[name])

    async def state(self, request: HttpRequest) -> Response:
        return await self._json(lambda: {**self.service.state(), "largest": self.largest})

    async def upload(self, request: HttpRequest) -> Response:
        name, part = checked_name(request.query_params.get("name", "")), request.query_params.get("part", "")
        folder = self.service.project.root
        handle, temporary = tempfile.mkstemp(prefix=UPLOAD, suffix=Path(name).suffix[:20], dir=folder)
        try:
            with os.fdopen(handle, "wb") as file:
                await self._received(request, self.largest, file.write)
            return await self._json(lambda: {"part": self.service.add_file(name, Path(temporary), part)})
        finally:
            Path(temporary).unlink(missing_ok=True)

    async def set_reading(self, request: HttpRequest) -> Response:
        reading = await self._struct(request, Reading)
        return await self._json(partial(self.service.set_reading, request.path_params["part"], reading))

    async def sheet(self, request: HttpRequest) -> Response:
        return await self._json(lambda: {"text": self.service.sheet(request.path_params["part"])})

    async def set_sheet(self, request: HttpRequest) -> Response:
        try:
            text = (await self._body(request)).decode()
        except UnicodeDecodeError:
            raise Refused(400, "the set-up sheet is no text in UTF-8") from None
        return await self._json(partial(self.service.set_sheet, request.path_params["part"], text))

    async def fill_in_sheet(self, request: HttpRequest) -> Response:
        return await self._json(partial(self.service.fill_in_sheet, request.path_params["part"]))

    async def remove_part(self, request: HttpRequest) -> Response:
        return await self._json(partial(self.service.remove_part, request.path_params["part"]))

    async def add_job(self, request: HttpRequest) -> Response:
        wanted = await self._struct(request, Request)
        return await self._json(lambda: {"job": self.service.add_job(request.path_params["part"], wanted)})

    async def stop_job(self, request: HttpRequest) -> Response:
        return await self._json(partial(self.service.stop_job, request.path_params["job"]))

    async def again(self, request: HttpRequest) -> Response:
        return await self._json(partial(self.service.again, request.path_params["job"]))

    async def remove_job(self, request: HttpRequest) -> Response:
        return await self._json(partial(self.service.remove_job, request.path_params["job"]))

    async def compare(self, request: HttpRequest) -> Response:
        try:
            jobs = msgspec.json.decode(await self._body(request), type=list[str])
        except (ValueError, RecursionError):
            raise Refused(400, "give a list of jobs") from None
        return await self._json(lambda: {"name": self.service.compare(jobs)})

    async def is_compared(self, request: HttpRequest) -> Response:
        name = request.path_params["name"]
        return await self._json(lambda: {"drawn": self.service.comparison(name) is not None})

    async def comparison(self, request: HttpRequest) -> Response:
        page = self.service.comparison(request.path_params["name"])
        if page is None:
            raise Refused(404, "this comparison is not drawn yet")
        return self._page_of_results(page)

    async def report(self, request: HttpRequest) -> Response:
        return self._page_of_results(self.service.report(request.path_params["job"]))

    async def feeds_page(self, request: HttpRequest) -> Response:
        return self._page_of_results(self.service.feeds_page(request.path_params["job"]))

    async def program(self, request: HttpRequest) -> Response:
        from starlette.responses import FileResponse

        path, name = self.service.program(request.path_params["job"])
        return FileResponse(path, media_type="application/octet-stream", filename=name)

    def _page_of_results(self, path: Path) -> Response:
        from starlette.responses import FileResponse

        return FileResponse(path, media_type="text/html", headers={"content-security-policy": SANDBOX})

    async def _json(self, call: Callable[[], Any]) -> Response:
        """What a call returns, made beside the loop: disks are slow."""
        from starlette.concurrency import run_in_threadpool
        from starlette.responses import Response

        found = await run_in_threadpool(call)
        return Response(msgspec.json.encode(found if found is not None else {}), media_type="application/json")

    async def _struct(self, request: HttpRequest, kind: type[Any]) -> Any:
        try:
            return msgspec.json.decode(await self._body(request), type=kind)
        except (ValueError, RecursionError) as error:
            raise Refused(400, f"this is not what is asked for here: {str(error)[:200]}") from None

    async def _body(self, request: HttpRequest) -> bytes:
        pieces: list[bytes] = []
        await self._received(request, LARGEST_BODY, pieces.append)
        return b"".join(pieces)

    async def _received(self, request: HttpRequest, largest: int, take: Callable[[bytes], object]) -> None:
        """Hand on the body, piece by piece, up to a size: what is larger is not waited for."""
        told = request.headers.get("content-length", "")
        size = int(told) if told.isdigit() and len(told) < 20 else 0
        if size > largest:
            raise Refused(413, f"this is too large: {size / 1e6:.4g} MB, and {largest / 1e6:.4g} MB at most are taken")
        if size + ROOM > free_disk(self.service.project.root):
            raise Refused(507, "the disk is full: make room, or start the app with --folder on another disk")
        received = 0
        async for piece in request.stream():
            received += len(piece)
            if received > largest:
                raise Refused(413, f"this is too large: {largest / 1e6:.4g} MB at most are taken")
            take(piece)


def _text(name: str) -> str:
    return files("toolpace.app").joinpath(name).read_text(encoding="utf-8")


def loopback(port: int) -> socket.socket:
    """A socket that listens on the loopback; port 0: any that is free. Raises UsageError."""
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if os.name == "posix":  # elsewhere it would let two servers share a port
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind(("127.0.0.1", port))
        listening.listen(128)
    except (OSError, OverflowError) as error:
        listening.close()
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise UsageError(f"--port {port}: {reason}; give another, or none for one that is free") from None
    return listening


def refuse_without_extra() -> None:
    """Raise UsageError where the libraries of the server are not installed."""
    try:
        import starlette
        import uvicorn  # noqa: F401
    except ImportError:
        raise UsageError(CURE) from None
    assert starlette


def new_token() -> str:
    """The key of one start."""
    return secrets.token_urlsafe(24)


def http_server(service: Service, port: int, token: str) -> uvicorn.Server:
    """What answers requests of a service; `run(sockets=[...])` does so until a signal, which it then raises again."""
    import uvicorn

    config = uvicorn.Config(
        application(service, port, token), log_level="critical", access_log=False, lifespan="off", server_header=False,
        timeout_graceful_shutdown=2, ws="none",
    )  # fmt: skip
    return uvicorn.Server(config)
