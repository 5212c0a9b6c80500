"""Who is let in: the browser of the one who started the app, and nobody else.

The server listens on the loopback alone. Other users of the computer, and pages of other sites in the same browser,
reach that too: so each request must name this host (else a name of another site was pointed here), must not come from
another origin, and must bear the token that only the address printed at the start has.
"""

from __future__ import annotations

import secrets
from http.cookies import CookieError, SimpleCookie
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs

from toolpace.common.cluster.pool import error_in_words
from toolpace.common.errors import printable

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

LONGEST_TARGET = 2000
"""Bytes of a path with its query."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Of the app's own page; what is sent with a policy of its own keeps that."""
HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}
ENTER = "open the address that `toolpace app` printed when it was started; it holds the key"
Refusal = tuple[int, str]


class Guard:
    """An ASGI application around another one."""

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self.app = app
        self.hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self.cookie = f"toolpace-{port}"
        self.token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what is refused, and let the rest through, with the headers that keep it in place."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            await send({"type": "websocket.close", "code": 1008})
            return
        begun = False

        async def guarded(message: Any) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                begun = True
                there = {name.lower() for name, _ in message["headers"]}
                more = HEADERS | {"content-security-policy": POLICY}
                added = [(name.encode(), value.encode()) for name, value in more.items() if name.encode() not in there]
                message = {**message, "headers": [*message["headers"], *added]}
            await send(message)

        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        refused = self._refused(scope, headers)
        if refused is not None:
            await _answer(guarded, *refused)
            return
        if scope["path"] == "/" and b"token" in scope["query_string"]:
            # The address with the token is left at once, so that it does not stay where others look.
            cookie = f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
            await _answer(guarded, 303, "", {"location": "/", "set-cookie": cookie})
            return
        try:
            await self.app(scope, receive, guarded)
        except Exception as error:
            if not begun:
                await _answer(guarded, 500, error_in_words(error))

    def _refused(self, scope: Scope, headers: dict[str, str]) -> Refusal | None:
        """Status and reason of a request that is not let in."""
        if headers.get("host", "") not in self.hosts:
            return 421, f"this is the app of toolpace, and not {printable(headers.get('host', '')[:60])}"
        if len(scope.get("raw_path", b"")) + len(scope["query_string"]) > LONGEST_TARGET:
            return 414, "the address is too long"
        if not self._has_token(scope, headers):
            return 401, ENTER
        origin, site = headers.get("origin"), headers.get("sec-fetch-site", "none")
        if (origin is not None and origin not in {f"http://{host}" for host in self.hosts}) or (
            site not in ("none", "same-origin")
        ):
            return 403, "this request comes from another site"
        return None

    def _has_token(self, scope: Scope, headers: dict[str, str]) -> bool:
        shown = [headers.get("x-toolpace-token", "")]
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
            shown += [cookies[self.cookie].value] if self.cookie in cookies else []
        except CookieError:
            pass
        if scope["path"] == "/" and scope["method"] == "GET":
            shown += parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=5).get("token", [])
        return any(secrets.compare_digest(each.encode(), self.token.encode()) for each in shown)


async def _answer(send: Send, status: int, text: str, headers: dict[str, str] | None = None) -> None:
    named = {"content-type": "text/plain; charset=utf-8", **(headers or {})}
    raw = [(name.encode(), value.encode("latin-1", "replace")) for name, value in named.items()]
    await send({"type": "http.response.start", "status": status, "headers": raw})
    await send({"type": "http.response.body", "body": text.encode()})
