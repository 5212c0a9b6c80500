"""Random contours under compensation of the radius, held against ways of the centre that are found by sampling."""
