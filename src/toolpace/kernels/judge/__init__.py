"""What the judge computes in loops; shared with nobody."""
