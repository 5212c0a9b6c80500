"""Joint positions along a path: all that a planner needs to know."""
