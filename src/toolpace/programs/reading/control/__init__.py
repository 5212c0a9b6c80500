"""The virtual control: what every control language drives, and what comes of it: moves, then points."""
