"""The matching of motion poses with program places."""
