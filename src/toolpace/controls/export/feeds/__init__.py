"""The feeds of a plan in the text of its program: when each block is passed, and how an F is written in its dialect."""
