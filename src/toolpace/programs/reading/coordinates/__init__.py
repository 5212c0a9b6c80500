"""What the words of a program mean in the machine and on the part: frames, offsets, set-up sheet, kinematics."""
