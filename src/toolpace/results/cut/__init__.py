"""What a simulation of a cut leaves on disk: figures, engagement, stock and a page."""
