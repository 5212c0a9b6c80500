"""Arcs and splines of Sinumerik from their words."""
