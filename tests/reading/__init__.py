"""Programs and tables."""
