"""Meshes of the path parameter."""
