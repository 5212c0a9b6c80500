"""G93 streams played by the real LinuxCNC, under their guard and the machine's own limits."""

from __future__ import annotations

import pytest

from testbed.linuxcnc.streams import STREAMS, played

MICROMETRE = 1e-6
LIKE_OTHERS = ("three axes, 2 ms", "3+2 by the tip", "two tools")
"""Streams each feature of which another one has too."""
REACH = 0.1
"""Distance from an axis at which two micrometres are asked of what turns [m]."""


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.thorough if name in LIKE_OTHERS else pytest.mark.sweep) for name in STREAMS],
)
def test_a_stream_takes_the_time_of_the_plan_and_every_joint_is_where_it_says(name, tmp_path):
    """The sheet's two tools are 20 and 35 mm, the machine's own has none: between them the stream waits."""
    case = STREAMS[name]
    _, messages, found = played(case, tmp_path)
    assert messages == (("toolpace: put in tool 2, then go on",) if case.sheet else ())
    for each in found:
        assert abs(each.cycles) <= 1
        assert each.slides < 2.0 * MICROMETRE and each.turns < 2.0 * MICROMETRE / REACH
        assert each.usage <= 1.01
