"""Standard cycles: holes, threads, hole patterns, swivelled planes."""
