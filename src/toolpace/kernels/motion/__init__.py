"""Laws of motion, and what they use of the limits."""
