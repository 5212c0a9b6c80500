"""The optimal planner: fastest within velocity, acceleration, jerk and feed, at any time."""
