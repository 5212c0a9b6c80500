"""What the other planners compute in loops."""
