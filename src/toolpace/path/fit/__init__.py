"""From a polyline with tolerance to a smooth curve: the runs of `Path.fit`."""
