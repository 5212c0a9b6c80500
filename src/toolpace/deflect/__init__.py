"""The tool is found off its path: where the path is, and the motion back onto it."""

from toolpace.deflect.pose import deflected_pose
from toolpace.deflect.projection import Projection, force, potential, project
from toolpace.deflect.replanning import replan

__all__ = ["Projection", "deflected_pose", "force", "potential", "project", "replan"]
