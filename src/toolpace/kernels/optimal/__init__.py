"""The interior-point methods of the optimal planner and of its bound."""
