"""An environment: move one cube from the middle of the table to each of its corners."""

from pigbench import envs

MIDDLE = (0.425, 0.0)
CORNERS = {
    "near_left": (0.325, 0.25),
    "near_right": (0.325, -0.25),
    "far_left": (0.525, 0.25),
    "far_right": (0.525, -0.25),
}

envs.register(
    envs.EnvSpec(
        name="cube-corners",
        num_cubes=1,
        episode_length=200,
        tasks=tuple(
            envs.Task(f"task{number}_{name}", start=(MIDDLE,), goal=(corner,))
            for number, (name, corner) in enumerate(CORNERS.items(), start=1)
        ),
        success_distance=0.03,  # metres; it is 0.04 in OGBench's environments
    )
)
