"""LinuxCNC 2.9's trajectory planner, cycle by cycle: its facts, in our own words.

In its units, mm and deg, since its thresholds are: a block's way is in mm, in deg where only rotary axes move.
"""
