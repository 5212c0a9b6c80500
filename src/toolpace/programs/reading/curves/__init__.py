"""Exact curves of programs, before points are laid along them."""
