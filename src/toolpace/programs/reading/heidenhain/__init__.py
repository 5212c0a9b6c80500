"""The reader of Heidenhain Klartext."""
