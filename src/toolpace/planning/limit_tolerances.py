"""The tolerances by which a planned motion may exceed a limit: promised, accepted, aimed at.

Each rung is a little below the one above it, so that what one stage leaves the next one need not touch, and rounding
between them (another grid of probes, another order of sums) never breaks what was promised.
"""

from __future__ import annotations

PROMISED = 1.0 + 1e-4
"""What users are promised: no limit is exceeded by more than 1e-4 of itself, at any time."""
GUARANTEE = 1.0 + 7e-5
"""Usage between nodes that no plan passes: where all else fails, the motion is slowed down to it."""
DETOUR = 1.0 + 6e-5
"""Usage of a detour back to the path; it starts from a motion that may itself use `ALLOWED`."""
ALLOWED = 1.0 + 5e-5
"""Usage between nodes that is left alone; what is above it is cut finer, lowered, and solved again."""
BRED = 1.0 + 2e-5
"""The same for the genetic planner, whose intervals are probed less densely than a spline's cells."""
KEPT_INTERVAL = BRED + 4e-5
"""Usage up to which an interval of a detour may be bred anew: that of a detour, counted from the genetic planner's."""
