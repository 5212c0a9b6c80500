"""The old name of `toolpace.deflection`, which goes with the next release."""

import warnings

from toolpace.deflection import Projection, deflected_pose, force, potential, project, replan

__all__ = ["Projection", "deflected_pose", "force", "potential", "project", "replan"]

warnings.warn("toolpace.deflect is called toolpace.deflection now", DeprecationWarning, stacklevel=2)
