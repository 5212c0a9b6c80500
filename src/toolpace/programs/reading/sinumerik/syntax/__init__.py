"""The syntax of blocks: tokens, expressions, statements."""
