"""What a program says: words, expressions, statements and their flow."""
