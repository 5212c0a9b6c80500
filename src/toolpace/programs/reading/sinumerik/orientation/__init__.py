"""Tool vectors, frames along the tool, the order of rotary axes."""
