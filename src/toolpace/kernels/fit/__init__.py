"""Quintic splines inside a tube."""
