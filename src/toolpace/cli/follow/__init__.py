"""The command `follow`: a plan followed live."""
