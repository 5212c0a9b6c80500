"""The figures of a control, fitted to what was measured of it."""
