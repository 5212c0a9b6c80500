"""The virtual control that every control language drives: commands in, moves and points out."""
