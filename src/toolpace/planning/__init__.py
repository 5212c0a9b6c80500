"""From joint positions along a path to the motion over time."""
