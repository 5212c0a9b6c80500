"""Path and pace together: the change of a fitted path, and of its pace, by which its motion is the fastest."""
