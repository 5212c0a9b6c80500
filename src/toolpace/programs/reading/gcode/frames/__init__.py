"""Frames of a word-address program: work offsets, programmable transformations, tilted planes."""
