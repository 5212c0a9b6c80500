"""Heidenhain Klartext: statements compiled once, executed on the virtual control."""
