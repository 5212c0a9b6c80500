"""The optimal planner: minimum time within velocity, acceleration, jerk and feed limits."""
