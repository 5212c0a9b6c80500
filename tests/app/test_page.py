"""The page of the app in Chromium, from a dropped program to the one that a control loads."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support.app_client import KLARTEXT, POCKET, REFUSED, service_of
from tests.support.report_pages import BROWSERS, GRAPHICS, Opened
from toolpace.cli import demo_programs

HOSTILE = "<img src=x onerror=alert`1`>"
PROGRAMS = {"pocket.ngc": POCKET, "pocket.h": KLARTEXT, "pocket.mpf": REFUSED}
ENDED = "state.jobs.length === {count} && state.jobs.every((job) => job.state === 'ended')"


@contextmanager
def browser(width: int = 1300):
    """A page of Chromium that is nowhere yet; skips where there is none."""
    executable = next((found for name in BROWSERS if (found := shutil.which(name))), "")
    if not executable:
        pytest.skip("Chromium is not installed (apt-get install chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=executable, args=list(GRAPHICS))
        context = chromium.new_context(viewport={"width": width, "height": 1000}, accept_downloads=True)
        page = context.new_page()
        found = Opened(page)
        page.on("console", lambda message: found.problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: found.problems.append(str(error)))
        page.on("dialog", lambda dialog: dialog.accept())
        page.on("request", lambda request: found.requests.append(request.url))
        try:
            yield found
        finally:
            chromium.close()


@contextmanager
def served(root):
    """The address of the app of a folder, served by a thread of this process."""
    pytest.importorskip("uvicorn", exc_type=ImportError)
    from toolpace.app.server import http_server, loopback

    with service_of(root) as service, loopback(0) as listening:
        port = listening.getsockname()[1]
        http = http_server(service, port, "key")
        thread = threading.Thread(target=lambda: http.run(sockets=[listening]))
        thread.start()
        try:
            yield f"http://127.0.0.1:{port}/?token=key"
        finally:
            http.should_exit = True
            thread.join(10.0)


def dropped(found: Opened, files: dict[str, str]) -> None:
    """Drop files onto the page, and wait until their programs are inspected."""
    count = found.run("state.parts.length") + len(files)
    found.page.set_input_files(
        "#file", [{"name": name, "mimeType": "", "buffer": text.encode()} for name, text in files.items()]
    )
    found.wait(f"state.parts.length === {count} && state.parts.every((part) => part.inspection)")


def chosen(found: Opened, program: str) -> None:
    """Choose a program of the list."""
    found.page.click(f"nav button:has-text('{program}')")


@pytest.mark.browser
@pytest.mark.sweep
def test_a_session_from_the_drop_to_the_program_to_load(tmp_path):
    """A refused program is cured by its button, planned by keyboard, changed, compared and loaded."""
    with served(tmp_path) as address, browser() as found:
        page = found.page
        page.goto(address)
        found.wait("state !== null")
        assert "key" not in page.url
        dropped(found, {f"{HOSTILE}.mpf".replace("<", "(").replace(">", ")"): REFUSED})
        assert "G41" in page.inner_text("#program")
        page.click("[data-cure='--compensation program']")
        found.wait("document.querySelector('#program').innerText.includes('every word is read')")
        page.select_option("[name=effort]", "low")
        page.focus("[data-focus=start]")
        page.keyboard.press("Enter")
        found.wait(ENDED.format(count=1))
        assert found.run("document.activeElement.dataset.focus") == "start"
        page.click("text=Change >> nth=0")
        page.fill("[name=tip_tolerance]", "0.05mm")
        page.select_option("[name=feeds]", "none")
        page.click("[data-focus=start]")
        found.wait(ENDED.format(count=2))
        usual, wide = found.run("state.jobs.map((job) => job.duration_s)")
        assert wide < usual
        for number in (1, 2):
            page.check(f"[aria-label='compare job {number}']")
        page.click("[data-focus=compare]")
        found.wait("document.querySelector('[data-focus=compared]')")
        assert "TRAORI" in loaded_program(found)
        assert found.problems == []
        assert {re.match(r"https?://[^/]*|\w+:", url)[0] for url in found.requests} == {address.split("/?")[0]}


@contextmanager
def started(folder):
    """The command in a process of its own, and the address that it prints; killed at the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", "toolpace", "app", "--folder", str(folder), "--no-browser"],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        address = next(re.search(r"http\S+", line)[0] for line in process.stdout if "http" in line)
        yield process, address
    finally:
        process.kill()
        process.wait(10.0)
        process.stdout.close()


@pytest.mark.browser
@pytest.mark.sweep
def test_a_server_that_is_killed_in_mid_job_loses_nothing(tmp_path):
    """Three dialects, one of them refused and cured; two jobs at once; SIGKILL, and a second start."""
    impeller = demo_programs.impeller_program(blocks_per_blade=20)
    with browser(width=700) as found:
        page = found.page
        with started(tmp_path / "app") as (process, address):
            page.goto(address)
            found.wait("state !== null")
            dropped(found, {**PROGRAMS, f"{HOSTILE[:4]}impeller.ngc".replace("<", "("): impeller})
            chosen(found, "pocket.mpf")
            page.click("[data-cure='--compensation program']")
            found.wait("state.parts.every((part) => part.inspection && part.inspection.refused.length === 0)")
            for program in ("impeller.ngc", *PROGRAMS):
                chosen(found, program)
                page.click("[data-focus=start]")
                page.wait_for_timeout(100)
            found.wait("state.jobs[0].steps.some((step) => step.step === 'fitting')")
            assert found.run("state.jobs.map((job) => [job.state, job.before])") == [
                ["running", 0], ["waiting", 1], ["waiting", 2], ["waiting", 3]
            ]  # fmt: skip
            assert "waits, 3 before it" in page.inner_text("#jobs")
            workers = workers_of(process.pid)
            process.send_signal(signal.SIGKILL)
            process.wait(10.0)
            found.wait("document.querySelector('#trouble').innerText.includes('does not answer')")
        assert len(workers) == 2
        until = time.monotonic() + 10.0
        while any(Path(f"/proc/{worker}").exists() for worker in workers) and time.monotonic() < until:
            time.sleep(0.05)
        assert not any(Path(f"/proc/{worker}").exists() for worker in workers)
        with started(tmp_path / "app") as (process, address):
            page.goto(address)
            found.problems.clear()
            found.wait("state !== null && state.parts.length === 4")
            found.wait(ENDED.format(count=4), seconds=120.0)
            assert found.run("state.jobs.map((job) => job.verdict)") == ["verified"] * 4
            for program, word in (("pocket.mpf", "TRAORI"), ("pocket.h", "M128"), ("pocket.ngc", "G43.4")):
                chosen(found, program)
                assert word in loaded_program(found)
            with page.context.expect_page() as look:
                page.click("text=Look >> nth=0")
            look.value.wait_for_load_state()
            assert look.value.evaluate("origin") == "null"  # the report is not of the app's origin
            assert found.run("document.documentElement.scrollWidth") <= 700
            assert found.problems == []
            process.send_signal(signal.SIGINT)
            assert process.wait(15.0) == 0


def workers_of(process: int) -> list[int]:
    """The processes that a process has started."""
    tasks = Path(f"/proc/{process}/task").iterdir()
    return [int(each) for task in tasks for each in (task / "children").read_text(encoding="ascii").split()]


def loaded_program(found: Opened) -> str:
    """The text of the program of the job on top."""
    with found.page.expect_download() as download:
        found.page.click("text=Load program >> nth=0")
    return Path(download.value.path()).read_text(encoding="utf-8")
