"""Motions followed live, whatever is measured and asked for, and a judge of their set-points."""
