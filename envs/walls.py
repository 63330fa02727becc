"""The walls around the table, which keep cubes within reach."""

WALLS = {
    "wall_near": ((0.003, 0.38, 0.2), (0.22, 0.0, 0.1)),
    "wall_right": ((0.205, 0.003, 0.2), (0.425, -0.38, 0.1)),
    "wall_far": ((0.003, 0.38, 0.2), (0.63, 0.0, 0.1)),
    "wall_left": ((0.205, 0.003, 0.2), (0.425, 0.38, 0.1)),
}
"""Half sizes and centre of each wall, in metres, by name."""
