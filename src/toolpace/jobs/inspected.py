"""The findings of `inspect` as JSON."""

from __future__ import annotations

import math

from toolpace.common.errors import printable
from toolpace.programs.reading.inspection import Inspection


def inspection_record(found: Inspection) -> dict[str, object]:
    """An entry of JSON: lengths in mm, angles in deg."""
    return {
        "program": printable(found.program),
        "dialect": found.dialect,
        "reason": printable(found.reason),
        "blocks": found.blocks,
        "five_axis_blocks": found.five_axis_blocks,
        "refused": [
            {"word": printable(each.word), "line": each.line, "count": each.count, "cure": printable(each.cure)}
            for each in found.refused
        ],
        "needs": [printable(sentence) for sentence in found.needs],
        "ignored": {printable(word): count for word, count in found.ignored.items()},
        "assumed": [printable(sentence) for sentence in found.assumed],
        "machines": list(found.machines),
        "not_on": {name: printable(why) for name, why in found.not_on.items()},
        "read_on": found.read_on,
        "arcs": found.arcs,
        "rapids": found.rapids,
        "stops": found.stops,
        "dwells": found.dwells,
        "dwell_s": found.dwell_s,
        "tools": [printable(tool) for tool in found.tools],
        "tip_mm": None if found.tip is None else [[value * 1e3 for value in each] for each in found.tip],
        "tilt_deg": None if found.tilt is None else [math.degrees(value) for value in found.tilt],
        "rotary_deg": {name: [math.degrees(value) for value in each] for name, each in found.rotary.items()},
    }
