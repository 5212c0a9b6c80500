"""Tool bending recomputed from set-points, machine, program and tool alone."""
