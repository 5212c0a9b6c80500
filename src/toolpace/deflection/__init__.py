"""Off the path, and back: replanning from a measured tip, and a follower that corrects live.

Names are imported when they are first used: a follower needs no planner.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolpace.deflection.measured_pose import deflected_pose
    from toolpace.deflection.new_trajectory import replan
    from toolpace.deflection.projection import Projection, force, potential, project

__all__ = ["Projection", "deflected_pose", "force", "potential", "project", "replan"]

_HOME = {"deflected_pose": "measured_pose", "replan": "new_trajectory"}
"""Name to the module that defines it; others are of the projection."""


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'toolpace.deflection' has no attribute '{name}'; it has {', '.join(__all__)}")
    return getattr(importlib.import_module(f"toolpace.deflection.{_HOME.get(name, 'projection')}"), name)
