"""Cutter-location data: APT and CLSF."""
