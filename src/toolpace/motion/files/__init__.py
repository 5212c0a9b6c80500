"""A motion on disk: set-points in two forms, and the plan itself."""
