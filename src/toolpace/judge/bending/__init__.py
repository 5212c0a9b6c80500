"""What a tool bends by, worked out anew: from set-points, machine file, program and the tool's figures alone."""
