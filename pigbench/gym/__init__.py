"""The environments in Gymnasium: `gymnasium.make("pigbench/cube-double-v0")`.

`gymnasium.make_vec("pigbench/cube-double-v0", num_envs=64)` steps a whole batch at once.
"""

import gymnasium

from pigbench import envs

VERSION = "v0"


def env_id(name: str) -> str:
    """An environment's id in Gymnasium."""
    return f"pigbench/{name}-{VERSION}"


def register() -> None:
    """Register the environments with Gymnasium, unless this has been done."""
    for name, spec in envs.SPECS.items():
        if env_id(name) not in gymnasium.registry:
            gymnasium.register(
                env_id(name),
                entry_point="pigbench.gym.single:SingleEnv",
                vector_entry_point="pigbench.gym.vector:BatchEnv",
                max_episode_steps=spec.episode_length,
                kwargs={"name": name},
            )
