"""The planner of Wu, Li, Liu and Perez (ACC 2009)."""
