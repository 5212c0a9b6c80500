"""Jobs: from a program to a folder of results, without the terminal."""
