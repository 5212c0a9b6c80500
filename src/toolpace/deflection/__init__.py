"""Off the path, and back: replanning from a measured tip, and a follower that corrects live."""
