"""Frames and tools of Fanuc, Mazak and Haas: random programs held against arithmetic of their own.

Nothing of the library makes a program, its sheet or the truth about it; machine files are read anew (`true_tip.chain`).
"""
