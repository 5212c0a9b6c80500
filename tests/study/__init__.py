"""The simulation study of the paper."""
