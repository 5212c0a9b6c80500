"""What controls make of programs: how fast they go from block to block."""
