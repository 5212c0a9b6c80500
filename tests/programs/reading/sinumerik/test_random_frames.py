"""Random programs of frames, planes and tool directions against kinematics and matrices of their own.

`python -m testbed.sinumerik_frames` tries 3000.
"""

from __future__ import annotations

import pytest

from testbed.sinumerik_frames.compare import compare
from testbed.sinumerik_frames.maker import MACHINES
from testbed.sinumerik_frames.programs import Program


@pytest.mark.parametrize("machine", MACHINES)
def test_random_programs_move_where_matrices_say(machine):
    """The tip and the tool axis at the end of every block, and the straight ways between, to a nanometre."""
    read = 0
    for seed in range(6):
        report = compare(Program(7000 + seed, machine))
        read += not report.refused
        assert max(report.off, report.axis, report.beside) < 1e-9, (seed, report)
    assert read >= 3
