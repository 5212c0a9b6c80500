"""Time laws: the path parameter over time."""
