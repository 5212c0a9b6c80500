"""The commands of `toolpace` that have a file of their own."""
