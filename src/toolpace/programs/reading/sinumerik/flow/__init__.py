"""Program flow: routines, jumps, loops, calls, variables."""
