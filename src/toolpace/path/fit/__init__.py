"""The fit of a smooth curve to a polyline within a tolerance."""
