"""Machine data and swivel data of Sinumerik controls."""
