"""Paths of the joints."""
