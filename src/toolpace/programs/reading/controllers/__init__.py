"""Controllers as data: what the words of each mean, and by what a program of it is known."""
