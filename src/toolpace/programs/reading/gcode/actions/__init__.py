"""Actions of G and M words."""
