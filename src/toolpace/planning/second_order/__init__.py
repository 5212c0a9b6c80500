"""The second-order planner: velocity, feed and acceleration limits only."""
