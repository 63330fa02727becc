"""What the scripted policies can do, available without importing JAX; `oracles` has their code."""

from dataclasses import dataclass

from pigbench.envs.cubes import MAX_CUBES


@dataclass(frozen=True)
class Scripted:
    """What a scripted policy can do.

    Attributes:
        most_cubes: the most cubes that it can move.
        ends_episodes: whether it ends its episodes itself.
    """

    most_cubes: int = MAX_CUBES
    ends_episodes: bool = False


SCRIPTED = {
    "play": Scripted(),
    "noisy": Scripted(),
    "replan": Scripted(most_cubes=1, ends_episodes=True),
}
