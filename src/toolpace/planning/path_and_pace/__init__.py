"""Path-and-pace optimisation: the change of a fitted path and of its speed law that saves most time."""
