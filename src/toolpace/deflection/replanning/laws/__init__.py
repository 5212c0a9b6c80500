"""Time laws of a detour and of the motion after it."""
