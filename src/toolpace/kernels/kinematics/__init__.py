"""Joint chains: forward, inverse, derivatives, and the choice among solutions."""
