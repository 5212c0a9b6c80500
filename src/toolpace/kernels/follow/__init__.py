"""The law of the live follower: path at a pace, and a correction, within the limits at every step."""
