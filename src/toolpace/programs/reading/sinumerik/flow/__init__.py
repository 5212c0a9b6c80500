"""Which block is next: routines, jumps, loops, calls, and the variables that decide."""
