"""Tool vectors, frames along the tool, and the order of the rotary axes."""
