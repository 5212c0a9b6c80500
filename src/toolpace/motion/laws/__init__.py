"""How the path parameter moves over time: one law a planner."""
