"""Rejoin motions within limits, travel and feed."""
