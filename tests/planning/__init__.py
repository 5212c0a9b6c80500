"""The planners, and the bound of their problem."""
