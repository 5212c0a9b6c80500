"""Models of the time that a control takes for a program."""
