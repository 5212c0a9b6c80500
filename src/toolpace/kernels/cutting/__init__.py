"""The stock as dexels: cutting it, and where a tool meets it."""
