"""From the text of a block to what it says: tokens, expressions, statements."""
