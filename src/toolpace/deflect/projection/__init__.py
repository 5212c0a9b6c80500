"""The projection of a deflection on the path: its nearest point, by bounds or by the paper's potential field."""

from toolpace.deflect.projection.point import Projection
from toolpace.deflect.projection.potential import force, potential
from toolpace.deflect.projection.project import project

__all__ = ["Projection", "force", "potential", "project"]
