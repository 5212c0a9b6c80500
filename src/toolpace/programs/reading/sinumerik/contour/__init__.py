"""Arcs and splines of Sinumerik."""
