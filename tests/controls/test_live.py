"""The page of a running follower: what it shows, whom it lets in, and that nobody makes the follower wait."""

from __future__ import annotations

import http.client
import json
import os
import signal
import socket
import sys
import time
from urllib.parse import urlsplit

import numpy as np
import pytest

import toolpace as tp
from tests.support.report_pages import watched
from toolpace.common.errors import UsageError
from toolpace.controls.live.server import EVENT, VIEWERS, Audience
from toolpace.controls.live.view import LiveView, live_page
from toolpace.deflection.following import Follower, Measurement
from toolpace.results.report import limit_shares

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pipe that never waits")
PROGRAM = "G21 G90 G17 G94\nG0 X10 Y-5 Z12 A0 C0\nG1 Z11 F900\nX13 Y-3 A2 C3 F500\nM2\n"


@pytest.fixture(scope="module")
def machine():
    return tp.Machine.load("xyzac-trunnion")


@pytest.fixture(scope="module")
def follower(machine):
    on = machine.reserved(0.1)
    toolpath = tp.read_text(PROGRAM, machine, name="short.ngc")
    return Follower(tp.plan(tp.Path.fit(toolpath, machine=on), on), machine, gain=0.1, max_correction=1e-4)


@pytest.fixture
def view(follower):
    follower.reset()
    with LiveView(follower, "<b>short</b>.law") as found:
        yield found


def answer(view, path=None, host=None, method="GET", **headers):
    """Status and headers of a request; by default as a browser on the page would ask."""
    address = urlsplit(view.address)
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=10)
    connection.putrequest(method, address.path if path is None else path, skip_host=True)
    for name, value in {"Host": host or address.netloc, **headers}.items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    response = connection.getresponse()
    connection.close()
    return response.status


def stepped(follower, count, view=None):
    """Set-points with a deflection from the half on."""
    points = []
    for k in range(count):
        off = np.array([5e-5, 0.0, 2e-5]) * (k > count // 2)
        points.append(follower.step(Measurement(k * follower.period, deflection=off)))
        if view is not None:
            view.show(points[-1], off)
    return points


def test_nobody_comes_in_without_the_token_or_from_elsewhere(view):
    address = urlsplit(view.address)
    port, token = address.port, address.path.strip("/")
    assert address.hostname == "127.0.0.1" and len(token) >= 32
    assert answer(view) == 200 and answer(view, host=f"localhost:{port}") == 200
    for path in ("/", "/events", f"/{token}", f"/{token[:-1]}/", f"/{token}/../", f"/{token}/page.py", "/x/events"):
        assert answer(view, path) == 404, path
    for host in ("attacker.example", f"attacker.example:{port}", "127.0.0.1", f"127.0.0.1.attacker.example:{port}"):
        assert answer(view, host=host) == 403, host
    assert answer(view, Sec_Fetch_Site="cross-site") == 403
    assert answer(view, method="POST") == 501


def test_events_are_the_set_points_and_their_use_of_the_limits(view, follower, machine):
    address = urlsplit(view.address)
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=10)
    connection.request("GET", f"{address.path}events")
    response = connection.getresponse()
    assert response.getheader("Content-Type") == "text/event-stream"
    points = stepped(follower, 150, view)
    view.close()
    text = response.read().decode()
    assert text.endswith("event: end\ndata: {}\n\n") and view.dropped == 0
    events = [json.loads(line[6:]) for line in text.splitlines() if line.startswith("data: {\"t\"")]
    assert len(events) == 3
    every = round(EVENT / follower.period)
    scale = np.where(machine.is_rotary, 180.0 / np.pi, 1e3)
    for k, event in enumerate(events):
        of_event = points[k * every : (k + 1) * every]
        last = of_event[-1]
        assert (event["t"], event["path_time"], event["pace"]) == (last.t, last.path_time, last.pace)
        np.testing.assert_allclose(event["q"], last.q * scale, atol=1e-6)
        np.testing.assert_allclose(event["correction"], last.correction[0] * scale, atol=1e-7)
        for kind, shares in limit_shares(of_event, machine).items():
            np.testing.assert_allclose(event["used"][kind], 100.0 * shares.max(axis=1), atol=2e-3)
    assert events[-1]["deflection"] == pytest.approx([50.0, 0.0, 20.0])


def test_a_server_that_stands_still_or_is_gone_holds_nobody_up(view, follower):
    process = view._process.pid
    os.kill(process, signal.SIGSTOP)
    points = stepped(follower, 300)
    began = time.perf_counter()
    for _ in range(10):
        for point in points:
            view.show(point)
    assert time.perf_counter() - began < 2.0 and view.dropped > 2500
    os.kill(process, signal.SIGKILL)
    os.kill(process, signal.SIGCONT)
    view._process.wait(10)
    before = view.dropped
    for point in points:
        view.show(point)
    assert view.dropped >= before + len(points) - 1


def test_a_browser_that_takes_nothing_misses_what_comes():
    audience = Audience()
    slow = [audience.join() for _ in range(VIEWERS)]
    assert audience.join() is None
    for k in range(5000):
        audience.tell(str(k))
    assert slow[0].qsize() <= 200 and slow[0].get() == "0"
    audience.leave(slow[1])
    late = audience.join()
    assert late.get() == "4400" and late.qsize() == 599
    audience.end()
    assert [late.get() for _ in range(600)][-1] is None


def test_the_server_ends_with_the_command(follower):
    view = LiveView(follower, "short.law")
    address = urlsplit(view.address)
    view.close()
    assert view._process.returncode == 0
    with pytest.raises(OSError), socket.create_connection((address.hostname, address.port), timeout=5):
        pass
    view.show(stepped(follower, 1)[0])
    assert view.dropped == 1


@pytest.mark.browser
@pytest.mark.sweep
def test_a_browser_shows_it_until_it_ends(view, follower):
    with watched(view.address, width=700, scheme="dark") as page:
        # as many as the pipe holds: none is dropped
        points = stepped(follower, 150, view)
        page.wait("toolpace.state() && toolpace.state().t > 0.149")
        assert page.page.locator("#badge").inner_text() == "live"
        page.wait(f"document.getElementById('q-0').textContent === '{1e3 * points[-1].q[0]:.4f}'")
        assert page.page.locator("h1 b").count() == 0
        view.close()
        page.wait("document.getElementById('badge').textContent === 'ended'")
        assert page.run("document.documentElement.scrollWidth") <= 701
        assert page.problems == []
        assert all(url.startswith((view.address, "data:")) for url in page.requests)


@pytest.mark.sweep
@pytest.mark.browser
def test_the_machine_moves_as_its_joints_do(follower, machine):
    """The tip is where the follower put it, path and correction together."""
    follower.reset()
    with LiveView(follower, "short.law", machine) as view, watched(view.address, width=700) as page:
        points = stepped(follower, 150, view)
        page.wait(f"document.getElementById('q-0').textContent === '{1e3 * points[-1].q[0]:.4f}'")
        page.page.wait_for_timeout(100)
        (tip,), _ = machine.forward(points[-1].q[None], np.array([machine.tool_length]))
        shown = page.run("toolpace.tip()")
        assert np.abs(np.array(shown) - 1e3 * tip).max() < 1e-3
        page.page.click("[data-camera=machine]")
        assert page.page.locator("#plane").count() == 0 and page.page.locator("#space canvas").is_visible()
        assert page.run("document.documentElement.scrollWidth") <= 701
        assert page.problems == []


def test_another_machine_than_that_of_the_law_is_refused(follower):
    with pytest.raises(UsageError, match="for another machine"):
        live_page(follower, "short.law", np.ones(5), tp.Machine.load("xyzbc-trunnion"))
