"""Set-points of which some are left out."""

from __future__ import annotations

from toolpace.motion.setpoints import SetPoints

ARRAYS = ("t", "q", "qd", "qdd", "qddd", "tip", "axis", "block")


def every(points, step):
    """Each step-th set-point."""
    return SetPoints(**{name: getattr(points, name)[::step] for name in ARRAYS}, joints=points.joints)


def first_of(points, count):
    """The first set-points."""
    return SetPoints(**{name: getattr(points, name)[:count] for name in ARRAYS}, joints=points.joints)
