#!/usr/bin/python3
"""Rows of set-points through HAL's streamer, run by /usr/bin/python3 within `halrun`.

It reads `played.json` and `rows.bin` (doubles), and writes `out.bin`: of each servo cycle whether limit3 took the row
over as it stood, the row, and what limit3 made of it.
"""

import array
import json
import time
from pathlib import Path

import hal

LEAD = 4
"""Cycles before the first row."""


def main():
    asked = json.loads(Path("played.json").read_text())
    width = asked["width"]
    rows = array.array("d", Path("rows.bin").read_bytes())
    count = len(rows) // width
    component = hal.component("toolpace-player")
    written = hal.stream(component, hal.streamer_base, "b" + "f" * width)
    sampled = hal.stream(component, hal.sampler_base, "b" + "f" * (2 * width))
    component.ready()
    sent = 0
    for _ in range(LEAD):
        # limit3 begins at the first row, which rests, as it stands; from zero it would chase
        written.write((True, *rows[:width]))
    out = array.array("d")
    deadline = time.monotonic() + 20.0 + 2.0 * count * asked["cycle"]
    started = False
    while (sent < count or written.depth) and time.monotonic() < deadline:
        while sent < count and written.writable:
            written.write((False, *rows[width * sent : width * (sent + 1)]))
            sent += 1
        if not started:
            hal.set_p("sampler.0.enable", "1")
            hal.set_p("streamer.0.enable", "1")
            started = True
        drain(sampled, out)
        time.sleep(0.005)
    time.sleep(0.1)
    drain(sampled, out)
    Path("out.bin").write_bytes(out.tobytes())
    Path("ended.json").write_text(json.dumps({"sent": sent, "left": written.depth, "lost": sampled.num_overruns}))


def drain(sampled, out):
    """What the servo thread has sampled."""
    while sampled.readable:
        out.extend(sampled.read())


main()
