"""The laws of a detour and of the way on."""
