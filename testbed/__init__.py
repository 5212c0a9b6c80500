"""Paths to plan and answers to hold plans against: what the tests and the benchmarks share.

It imports toolpace, and neither tests nor benchmarks.
"""
