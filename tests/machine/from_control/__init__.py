"""Machines from the files of their controls."""
