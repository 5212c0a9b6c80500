"""Files that a control loads."""
