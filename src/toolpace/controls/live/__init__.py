"""A running follower in a browser: what it sends, and the server that shows it, a process of its own."""
