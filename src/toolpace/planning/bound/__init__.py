"""How fast any motion could be at best: lower bounds of the duration, and how they are raised."""
