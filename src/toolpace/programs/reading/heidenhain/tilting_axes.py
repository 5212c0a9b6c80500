"""M138: the rotary axes that tilted planes and M128 count with."""

from __future__ import annotations

from collections.abc import Collection

from toolpace.programs.reading.control.control import Control


def take(control: Control, letters: Collection[str]) -> None:
    """Note that M138 changes nothing, or refuse it where it names some of the rotary axes only.

    "The TNC performs the above functions only in those tilting axes that you have defined using M138", without axes in
    all again (TNC 620 Conversational, "Selecting tilting axes: M138").
    """
    own = {name.upper() for name in control.poses.rotary_names}
    if letters and own - set(letters):
        cure = "leave it out: planes and M128 are read with all rotary axes of the machine"
        control.findings.refused("M138 with some of the rotary axes", control.line, cure)
    else:
        control.findings.ignored("M138")
