"""What a planned motion cuts: time in air and in material, volume, what is left, and collisions."""
