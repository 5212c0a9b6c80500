"""The genetic planner (Wu, Li, Liu and Perez, ACC 2009)."""
