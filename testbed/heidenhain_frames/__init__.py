"""Random Klartext programs over frames, planes and tools, held against kinematics and frame arithmetic of their own.

Nothing of the reader is used to write a program or to say where its blocks end; the machine file is read anew.
"""
