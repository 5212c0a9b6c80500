"""The way back: joints as splines of time, as short as limits, travel and feed allow."""
