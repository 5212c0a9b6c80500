"""What a report holds, and what a browser makes of it."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
import zlib
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

MISSING = -(2**31)
UNDRAWN = ("theme", "arrays", "motion", "playback", "tracks", "timeline", "stock", "program", "player")
"""Scripts of the report that calculate, and need no page for that."""
STUBS = """
const frames = [], look = { getPropertyValue: () => "", fontFamily: "" };
globalThis.document = {};
globalThis.getComputedStyle = () => look;
globalThis.requestAnimationFrame = (f) => frames.push(f);
globalThis.cancelAnimationFrame = (k) => { frames[k - 1] = null; };
"""
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
GRAPHICS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def embedded(text: str) -> dict[str, Any]:
    """The data of a page."""
    return json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text)[1])


class Arrays:
    """The arrays of a page, read by its description and not by the code that wrote them."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.bytes = zlib.decompress(base64.b64decode(data["arrays"]))

    def numbers(self, entry: dict[str, Any]) -> np.ndarray:
        """(n,) values, nan where there is none."""
        n, width, at = entry["n"], entry["width"], entry["at"]
        whole, out = 0, []
        for i in range(n):
            small = sum(self.bytes[at + k * n + i] << (8 * k) for k in range(width))
            step = -(small + 1) // 2 if small & 1 else small // 2
            whole = (whole + step + 2**31) % 2**32 - 2**31
            out.append(np.nan if whole == MISSING else whole * entry["unit"])
        return np.array(out)

    def text(self, entry: dict[str, Any]) -> str:
        """Text that is kept as it is."""
        return self.bytes[entry["at"] : entry["at"] + entry["n"]].decode()


@dataclass
class Opened:
    """A page in a browser, and what went wrong there."""

    page: Any
    problems: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def run(self, script: str) -> Any:
        """The value of an expression of the page."""
        return self.page.evaluate(script)


    def wait(self, script: str, seconds: float = 60.0) -> None:
        """Until an expression of the page is true; the page's own policy lets no other way in."""
        for _ in range(round(20 * seconds)):
            if self.run(script):
                return
            self.page.wait_for_timeout(50)
        raise AssertionError(f"never true: {script}; {self.problems}")


def opened(path: Path, width: int = 1300, height: int = 1000, scheme: str = "light"):
    """The page of a file in Chromium, once it is ready; skips where there is none."""
    return watched(path.resolve().as_uri(), width, height, scheme)


@contextmanager
def watched(address: str, width: int = 1300, height: int = 1000, scheme: str = "light"):
    """The page at an address in Chromium, once it is ready; skips where there is none."""
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), "")
    if not browser:
        pytest.skip("Chromium is not installed (apt-get install chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=browser, args=list(GRAPHICS))
        page = chromium.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
        found = Opened(page)
        page.on("console", lambda message: found.problems.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: found.problems.append(str(error)))
        page.on("request", lambda request: found.requests.append(request.url))
        page.goto(address)
        try:
            found.wait("window.toolpaceReady")
            yield found
        finally:
            chromium.close()


def calculated(text: str, script: str) -> Any:
    """What a script returns with the `player` and the `data` of a page, in Node.js and without a page: the value of
    the body of a function. `frames` are those that were asked for. Skips where there is no Node.js."""
    driver = pytest.importorskip("playwright._impl._driver")
    folder = files("toolpace.results.report").joinpath("player")
    scripts = "\n".join(folder.joinpath(f"{name}.js").read_text(encoding="utf-8") for name in UNDRAWN)
    data = json.dumps(embedded(text))
    main = f"""Arrays.of(data.arrays).then((arrays) => {{
        const player = new Player(data, arrays);
        process.stdout.write(JSON.stringify((() => {{ {script} }})()));
    }});"""
    ran = subprocess.run(
        [driver.compute_driver_executable()[0], "-"], input=f"{STUBS}{scripts}\nconst data = {data};\n{main}",
        capture_output=True, text=True, encoding="utf-8", timeout=60, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr[-2000:]
    return json.loads(ran.stdout)
