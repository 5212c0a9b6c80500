"""The planner without jerk limits."""
