"""The projection of a deflection on the path: the nearest point, by bounds or by the paper's potential field."""

from toolpace.deflection.replanning.projection.point import Projection
from toolpace.deflection.replanning.projection.potential import force, potential
from toolpace.deflection.replanning.projection.project import project

__all__ = ["Projection", "force", "potential", "project"]
