"""Feeds of a plan in the text of its program."""
