"""What a program says: points, tool axes, feeds, tolerances; and the readers of programs."""
