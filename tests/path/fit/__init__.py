"""The fit of a path to a program."""
