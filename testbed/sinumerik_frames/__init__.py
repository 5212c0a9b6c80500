"""Random Sinumerik programs of frames, planes and tool directions, held against kinematics and frames of their own.

Nothing of the library makes a program, its sheet or the truth about it: frames are 4 by 4 matrices written here from
the manuals, and the machine is `testbed.true_tip.chain`, read anew from its file.
"""
