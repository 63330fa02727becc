"""What every cube is like, and how many there is room for."""

CUBE_HALF_SIZE = 0.02  # metres
CUBE_DENSITY = 1240.0  # kilograms per cubic metre: a cube weighs 79 g
MAX_CUBES = 16  # more would start on one another, and push each other off the table
