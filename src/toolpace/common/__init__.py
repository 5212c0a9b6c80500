"""What every room stands on: errors, units, checked arrays, files, workers."""
