"""LinuxCNC's own interpreter, the command `rs274`, run on a program in a folder of its own."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

from testbed.linuxcnc.canon import Judged, read_calls

SECONDS = 5.0
"""Most time of one program."""
NAME = "compared-program.ngc"
"""Of the file, which none that it calls has."""


def available() -> str | None:
    """Path of `rs274`; None where LinuxCNC is not installed."""
    return shutil.which("rs274")


def copy_called(folder: Path, place: Path) -> None:
    """The programs of a folder, which one of them may call, into another."""
    for path in sorted(folder.glob("*.ngc")):
        if path.is_file():
            shutil.copyfile(path, place / path.name)


def judged(
    program: str,
    parameters: Mapping[int, float] | None = None,
    tools: Mapping[int, float] | None = None,
    diameters: Mapping[int, float] | None = None,
    *,
    block_delete: bool = True,
    seconds: float = SECONDS,
    beside: Path | None = None,
) -> Judged:
    """What `rs274` makes of a program.

    parameters: of the interpreter, by number [inch, deg]. tools: length by number [inch]; tool n stands in pocket n.
    diameters: of tools, by number [inch].
    beside: a folder with the files that the program calls; they are looked for nowhere else.

    A program that does not come to an end has that error, and no motions.
    """
    with tempfile.TemporaryDirectory(prefix="rs274.") as folder:
        place = Path(folder)
        of_ini = []
        if beside is not None:
            copy_called(beside, place)
            ini = f"[DISPLAY]\nPROGRAM_PREFIX = {place}\n[RS274NGC]\nSUBROUTINE_PATH = {place}\n"
            (place / "part.ini").write_text(ini, encoding="utf-8")
            of_ini = ["-i", "part.ini"]
        (place / NAME).write_text(program, encoding="utf-8")
        lines = [f"{number} {value:.12f}" for number, value in sorted((parameters or {5220: 1.0}).items())]
        (place / "part.var").write_text("\n".join(lines) + "\n", encoding="utf-8")
        wide = {number: f" D{diameter:.12f}" for number, diameter in (diameters or {}).items()}
        table = [f"T{n} P{n} Z{length:.12f}{wide.get(n, '')}" for n, length in sorted((tools or {}).items())]
        (place / "part.tbl").write_text("\n".join(table) + "\n", encoding="utf-8")
        command = ["rs274", *(["-b"] if block_delete else []), "-g", *of_ini, "-v", "part.var", "-t", "part.tbl"]
        command.append(NAME)
        try:
            done = subprocess.run(
                command, cwd=place, env={"HOME": folder, "PATH": "/usr/bin:/bin", "LC_ALL": "C.UTF-8"}, timeout=seconds,
                capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False, errors="replace",
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return read_calls("", f"it does not come to an end in {seconds:g} s")
    if done.returncode not in (0, 1):
        raise RuntimeError(f"rs274 ended with {done.returncode}: {done.stderr[-500:]}")
    said = [line for line in done.stderr.splitlines() if line.strip() and line != "executing"]
    error = (" | ".join(said) or "refused") if done.returncode else ""
    return read_calls(done.stdout, error)
