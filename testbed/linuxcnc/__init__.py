"""LinuxCNC's own interpreter as a judge: programs to try, its canonical calls, and walks along both readings."""
