"""The lower bound."""
