"""Where a planner puts its nodes."""
