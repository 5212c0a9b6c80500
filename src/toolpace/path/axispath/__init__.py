"""Joint paths: joint positions over a path parameter."""
