"""Curves of programs, kept exact until points are laid along them."""
