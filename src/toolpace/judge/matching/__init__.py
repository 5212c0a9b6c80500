"""Which places of the program belong to each pose of a motion, and on which side of it they are."""
