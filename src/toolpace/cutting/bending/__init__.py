"""What a cutting force does to the tool, what force cutting takes, and paths compensated for it."""
