"""The server of the page of a running follower: reads its rows from standard input, and shows them in browsers.

    python -m toolpace.controls.live.server < head (a line of JSON), page, rows (live/rows.py)

It listens on the loopback alone, at an address with a token, and tells its port in a line. Rows are gathered into
events of `EVENT` seconds, which go to each browser through a queue that drops what a slow one does not take. It ends
with its input.
"""

from __future__ import annotations

import hmac
import json
import queue
import sys
import threading
from collections import deque
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, BinaryIO

from toolpace.controls.live.rows import KINDS, Row, RowForm

EVENT = 0.05
"""Time of the run in an event [s]."""
KEPT = 600
"""Events that a browser gets at first: of the last half minute."""
WAITING = 200
"""Events that wait for a slow browser at most: what comes then is dropped."""
VIEWERS = 8
"""Browsers that may look on at the same time."""
IDLE = 1.0
"""Time after which a browser that has nothing to be told is asked whether it is still there [s]."""
PATIENCE = 5.0
"""Time that a browser may take to receive what is sent to it [s]."""
LOOPBACK = "127.0.0.1"


class Gathered:
    """Rows gathered into events: of shares of the limits the largest, of all else the last."""

    def __init__(self, limits: list[list[float]], scale: list[float]) -> None:
        """Take limits (3, m) of the joints, and what makes mm and deg of m and rad (m,)."""
        self.limits, self.scale = limits, scale
        self.begin = 0.0
        self.used = {kind: [0.0] * 3 for kind in KINDS}

    def take(self, row: Row) -> dict[str, Any] | None:
        """The event that a row completes; None where it goes on."""
        if row.t < self.begin:
            self.begin = row.t
        for kind, limit, whole, own in zip(KINDS, self.limits, row.motion[1:], row.correction[1:]):
            now = self.used[kind]
            for most, v, c in zip(limit, whole, own):
                for k, value in enumerate((v - c, c, v)):
                    now[k] = max(now[k], 100.0 * abs(value) / most)
        if row.t - self.begin < EVENT * (1.0 - 1e-9):
            return None
        found = {
            "t": row.t, "path_time": row.path_time, "pace": row.pace, "status": row.status,
            "q": [round(v * s, 6) for v, s in zip(row.motion[0], self.scale)],
            "correction": [round(v * s, 7) for v, s in zip(row.correction[0], self.scale)],
            "deflection": [1e6 * v if v == v else None for v in row.deflection],
            "used": {kind: [round(share, 3) for share in shares] for kind, shares in self.used.items()},
        }  # fmt: skip
        self.begin = row.t
        self.used = {kind: [0.0] * 3 for kind in KINDS}
        return found


class Audience:
    """The browsers that look on, and the last events."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._queues: list[queue.Queue[str | None]] = []
        self._last: deque[str] = deque(maxlen=KEPT)
        self.ended = False

    def join(self) -> queue.Queue[str | None] | None:
        """The queue of a new one, which begins with what has been; None where there are too many."""
        with self._lock:
            if len(self._queues) >= VIEWERS:
                return None
            found: queue.Queue[str | None] = queue.Queue(KEPT + WAITING)
            for event in self._last:
                found.put_nowait(event)
            if self.ended:
                found.put_nowait(None)
            self._queues.append(found)
            return found

    def leave(self, left: queue.Queue[str | None]) -> None:
        """A browser is gone."""
        with self._lock:
            self._queues.remove(left)

    def tell(self, event: str) -> None:
        """All of them; those that are slow miss it."""
        with self._lock:
            self._last.append(event)
            for each in self._queues:
                if each.qsize() < WAITING:
                    each.put_nowait(event)

    def end(self) -> None:
        """There is no more."""
        with self._lock:
            self.ended = True
            for each in self._queues:
                each.put_nowait(None)

    def __len__(self) -> int:
        with self._lock:
            return len(self._queues)


class Server(ThreadingHTTPServer):
    """The page and its events, to who knows the token."""

    daemon_threads = True

    def __init__(self, token: str, page: bytes) -> None:
        super().__init__((LOOPBACK, 0), Handler)
        self.token, self.page, self.audience = token, page, Audience()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that has gone away is no error."""


class Handler(BaseHTTPRequestHandler):
    """One request."""

    server: Server
    protocol_version = "HTTP/1.1"
    timeout = PATIENCE

    def log_message(self, format: str, *args: object) -> None:
        """Nothing is logged: standard error is that of the follower."""

    def do_GET(self) -> None:
        """The page or the events; all else is refused."""
        port = self.server.server_address[1]
        if self.headers.get("Host") not in (f"{LOOPBACK}:{port}", f"localhost:{port}"):
            self._answer(HTTPStatus.FORBIDDEN)
            return
        if self.headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
            self._answer(HTTPStatus.FORBIDDEN)
            return
        token, slash, name = self.path.removeprefix("/").partition("/")
        known = hmac.compare_digest(token.encode(), self.server.token.encode())
        if not (known and slash and name in ("", "events")):
            self._answer(HTTPStatus.NOT_FOUND)
        elif name == "events":
            self._events()
        else:
            self._answer(HTTPStatus.OK, self.server.page, "text/html; charset=utf-8")

    def _answer(self, status: HTTPStatus, body: bytes = b"", kind: str = "text/plain") -> None:
        self.send_response(status)
        self._send_headers(kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def _send_headers(self, kind: str) -> None:
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")

    def _events(self) -> None:
        waiting = self.server.audience.join()
        if waiting is None:
            self._answer(HTTPStatus.SERVICE_UNAVAILABLE)
            return
        try:
            self.send_response(HTTPStatus.OK)
            self._send_headers("text/event-stream")
            self.send_header("Connection", "close")
            self.end_headers()
            while True:
                try:
                    event = waiting.get(timeout=IDLE)
                except queue.Empty:
                    self.wfile.write(b":\n\n")
                    continue
                self.wfile.write(b"event: end\ndata: {}\n\n" if event is None else f"data: {event}\n\n".encode())
                if event is None:
                    return
        except OSError:  # it has gone away, or takes nothing
            return
        finally:
            self.close_connection = True
            self.server.audience.leave(waiting)


def serve(stream: BinaryIO, tell_port: Any) -> None:
    """Show what comes from a stream until that ends."""
    head = json.loads(stream.readline())
    server = Server(head["token"], stream.read(head["page"]))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    tell_port(server.server_address[1])
    form, gathered = RowForm(head["joints"]), Gathered(head["limits"], head["scale"])
    while len(data := stream.read(form.size)) == form.size:
        event = gathered.take(form.unpack(data))
        if event is not None:
            server.audience.tell(json.dumps(event, separators=(",", ":")))
    server.audience.end()
    # what waits for the browsers is sent, but not for long
    gone = threading.Event()
    for _ in range(20):
        if not len(server.audience):
            break
        gone.wait(0.05)
    server.shutdown()


def main() -> None:
    """As the file's head says."""
    serve(sys.stdin.buffer, lambda port: print(port, flush=True))


if __name__ == "__main__":
    main()
