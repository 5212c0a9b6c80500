"""The command `app`: a page on this computer, in the browser."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import webbrowser
from typing import Annotated

from cyclopts import Parameter
from rich.text import Text

from toolpace.cli.console import new_console
from toolpace.cli.options import Switch
from toolpace.common.errors import UsageError, printable

FOLDER = "~/toolpace-app"
"""Where programs and results are kept unless told."""
LARGEST_PORT = 65535


def has_screen() -> bool:
    """Whether a browser has where to show a page: in a terminal it would take the terminal."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def app_command(
    *,
    folder: Annotated[
        str, Parameter(name=["--folder", "-f"], help="Folder for programs, jobs and results; what is there goes on.")
    ] = FOLDER,
    port: Annotated[
        int | None, Parameter(help="Port of the loopback (127.0.0.1); by default any that is free.")
    ] = None,
    no_browser: Annotated[bool, Switch, Parameter(help="Open no browser; the address is printed.")] = False,
) -> int:
    """Open a page in the browser to inspect, plan, compare and export programs without a terminal.

    The page is served to this computer alone, by an address that holds a key. What it
    does is what the commands do. Everything is kept in the folder: close the page, or
    stop the app with Ctrl-C, and start it again; jobs that had not ended go on. Needs
    pip install 'toolpace[app]'. docs: the app.

    For example:

        toolpace app
        toolpace app --folder parts/app --port 8080 --no-browser
    """
    from toolpace.app import serving

    if port is not None and not 1 <= port <= LARGEST_PORT:
        raise UsageError(f"--port {port}: give a number from 1 to {LARGEST_PORT}, or none for a port that is free")
    console = new_console()
    with serving(folder, port or 0) as app:
        console.print(Text(printable(f"folder       {app.folder}")), soft_wrap=True)
        console.print(Text(f"open         {app.address}"), soft_wrap=True)
        console.print("stop         Ctrl-C", soft_wrap=True)
        if not no_browser and has_screen():
            # Some browsers return when they are closed.
            threading.Thread(target=webbrowser.open, args=(app.address,), daemon=True).start()
        with contextlib.suppress(KeyboardInterrupt):
            app.until_signal()
        console.print("stopped      what has not ended goes on with the next start", soft_wrap=True)
    return 0
