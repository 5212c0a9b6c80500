"""Compiled functions by themselves."""
