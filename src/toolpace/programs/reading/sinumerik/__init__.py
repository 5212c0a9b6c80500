"""The reader of Sinumerik programs (840D, 828D and relatives)."""
