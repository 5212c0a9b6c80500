"""What tests of several rooms need: random machines, paths and tool paths, motions in closed form, other solvers."""
