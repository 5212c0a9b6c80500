"""Standard cycles: holes, threads, patterns of holes, swivelled planes."""
