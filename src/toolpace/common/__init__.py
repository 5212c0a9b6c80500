"""What every room stands on: errors, units, checked arrays, files, workers."""

__version__ = "0.1.0"
