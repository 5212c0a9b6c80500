"""Lower bounds of the duration, and how they are raised."""
