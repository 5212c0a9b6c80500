"""Off the path, and back: replanning from a measured tip, and a follower that corrects live.

Names are imported when they are first used: a follower needs no planner.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from toolpace.deflection.replanning.new_trajectory import replan
    from toolpace.deflection.replanning.pose import deflected_pose
    from toolpace.deflection.replanning.projection import Projection, force, potential, project

__all__ = ["Projection", "deflected_pose", "force", "potential", "project", "replan"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'toolpace.deflection' has no attribute '{name}'; it has {', '.join(__all__)}")
    return getattr(importlib.import_module("toolpace.deflection.replanning"), name)
