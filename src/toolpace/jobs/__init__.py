"""What the commands do with a program, without the terminal: workers of a cluster do it too."""
