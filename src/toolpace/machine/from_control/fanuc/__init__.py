"""Fanuc: parameters as the control punches them."""
