"""The material that is cut."""
