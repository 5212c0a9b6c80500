"""Feeds by what is cut: faster in air, or up to the load of a teacher, or up to limits of the cut."""
