"""Where the tip of the tool in the spindle really is: plans held against kinematics and programs of their own.

Nothing of the library is used to make a program, a sheet or the truth about them; the machine file is read anew.
"""
