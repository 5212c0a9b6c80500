"""Lower bounds of the duration of any motion."""
