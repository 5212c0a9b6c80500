"""Programs of Sinumerik 840D, 828D and their kin."""
