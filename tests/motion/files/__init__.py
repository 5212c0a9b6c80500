"""Tests of the time laws."""
