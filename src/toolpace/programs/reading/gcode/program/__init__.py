"""The text of word-address programs: words, expressions, statements, flow."""
