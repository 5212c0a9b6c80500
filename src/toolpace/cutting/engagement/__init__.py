"""Where the tool's surface is in material, along a motion."""
