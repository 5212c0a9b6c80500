"""The search for the clamping and tool with which a program is fastest on a machine.

search for a set-up:
  choices: the fixtures, turns, places and tools at hand                                       Choices
  many clampings of the part, the given one first                                              Clamping
      rotary joints along the program; the place moved to the nearest one within all travels   FeasiblePosition
      a smooth path in wider tolerances, planned without bound and guard                       Trial
  the best of them, planned in full with a bound, and held against travel and zones            PlannedSetUp
  all of it                                                                                    FoundSetUp

The mathematics: docs/design/clamping.md.
"""

from __future__ import annotations
