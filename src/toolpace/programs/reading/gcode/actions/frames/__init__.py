"""Work offsets, and what a program lays over them: shifts, mirrors, scales, turns and tilted planes."""
