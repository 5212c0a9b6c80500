"""The planner of the paper (Wu, Li, Liu and Perez, ACC 2009)."""
