"""The reader of word-address programs (G-code)."""
