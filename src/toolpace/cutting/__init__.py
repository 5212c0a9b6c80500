"""What the tool meets: cutting forces, and the bending of the tool."""
