"""Work offsets, and the frames that a program lays over them."""
