"""What the scripted policies can do, available without importing JAX; `oracles` has their code."""

from dataclasses import dataclass

from pigbench.envs.cubes import MAX_CUBES
from pigbench.errors import UserError

TRIPS = 2  # of `replan`, which then ends the episode: home, and away
TRIP_STEPS = 150  # control steps after which it gives a trip up


@dataclass(frozen=True)
class Scripted:
    """What a scripted policy can do.

    Attributes:
        most_cubes: the most cubes that it can move.
        episode_rows: the most rows of an episode if the policy ends episodes itself, else 0.
    """

    most_cubes: int = MAX_CUBES
    episode_rows: int = 0

    def require(self, policy: str, environment: str, num_cubes: int) -> None:
        """Raise UserError if the environment has more cubes than the policy can move."""
        if num_cubes > self.most_cubes:
            raise UserError(
                f"{environment} has {num_cubes} cubes, and {policy} moves no more than "
                f"{self.most_cubes}: choose another policy"
            )


SCRIPTED = {
    "play": Scripted(),
    "noisy": Scripted(),
    "replan": Scripted(most_cubes=1, episode_rows=TRIPS * TRIP_STEPS + 1),
}
