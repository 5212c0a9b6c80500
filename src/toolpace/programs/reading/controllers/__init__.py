"""Controllers as data: the meaning of words, and the signs by which programs are recognised."""
