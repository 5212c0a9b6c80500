"""What the languages of programs have in common: expressions, and the flow from block to block."""
