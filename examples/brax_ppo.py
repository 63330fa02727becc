"""Train Brax's PPO on a cube environment with a dense reward, and plot the return over training.

    python examples/brax_ppo.py --steps 500000 --out results/brax

trains `reach` in a few minutes on two cores. `--reward place` is the whole task and takes much
longer. Steps are control steps of all simulations together.
"""

import dataclasses
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp

from pigbench import cli, envs
from pigbench.errors import require
from pigbench.report import canvas
from pigbench.seeds import Seed
from pigbench.support import files

MINIBATCHES = 8


def replicate(tree: Any, devices: Sequence[jax.Device]) -> Any:
    """A copy of every leaf for each device, along a new leading axis."""
    return jax.tree.map(lambda leaf: jnp.stack([jnp.asarray(leaf)] * len(devices)), tree)


# Brax 0.14.2, the latest release, still calls this function, which JAX has removed.
if not hasattr(jax, "device_put_replicated"):
    jax.device_put_replicated = replicate

from brax.envs.base import State, Wrapper  # noqa: E402  after what it needs
from brax.training.agents.ppo import networks, train  # noqa: E402


class WithGoal(Wrapper):
    """Adds the vectors from the cubes to their targets to the observation."""

    def reset(self, rng: jax.Array) -> State:
        """As in the environment."""
        return self._with_goal(self.env.reset(rng))

    def step(self, state: State, action: jax.Array) -> State:
        """As in the environment."""
        return self._with_goal(self.env.step(state, action))

    @property
    def observation_size(self) -> int:
        """The environment's observation size plus three numbers per cube."""
        return self.env.observation_size + 3 * self.env.spec.num_cubes

    def _with_goal(self, state: State) -> State:
        goal = state.info["goal"]
        places = self.env.layout.group("object_positions").values()
        ways = [goal[place] - state.obs[place] for place in places]
        return state.replace(obs=jnp.concatenate([state.obs, *ways]))


@dataclasses.dataclass(frozen=True)
class Example:
    """Train with Brax's PPO, and plot the return of evaluation episodes."""

    out: Path
    """Folder for the table and the plot."""
    environment: str = "cube-single"
    """Environment; see `pigbench list envs`."""
    reward: Literal["reach", "place"] = "reach"
    """Reward."""
    steps: int = 500_000
    """Control steps of all simulations together."""
    evaluations: int = 10
    """Evaluations, including one before training."""
    simulations: int = 64
    """Simulations that run in parallel."""
    episode_length: int = 100
    """Control steps per episode."""
    batch_size: int = 64
    """Segments of ten steps per minibatch; there are eight minibatches per update."""
    seed: Seed = 0
    """Random seed."""

    def __post_init__(self) -> None:
        counts = "steps", "evaluations", "simulations", "episode_length", "batch_size"
        require(self, lambda x: x >= 1, "at least 1", *counts)
        segments = MINIBATCHES * self.batch_size
        divisor = f"a divisor of {segments}, which is {MINIBATCHES} times the batch size"
        require(self, lambda x: segments % x == 0, divisor, "simulations")

    def run(self) -> None:
        """Train and write the files."""
        files.require_folder(self.out)
        env = WithGoal(envs.make(self.environment, reward=self.reward))
        rows: list[tuple[int, float, float]] = []

        def progress(step: int, metrics: dict[str, Any]) -> None:
            mean, deviation = (
                float(metrics[f"eval/episode_reward{ending}"]) for ending in ("", "_std")
            )
            rows.append((step, mean, deviation))
            print(f"{step:>10,} steps: return {mean:.2f} ({deviation:.2f} over episodes)")

        train.train(
            environment=env,
            num_timesteps=self.steps,
            num_evals=self.evaluations,
            num_envs=self.simulations,
            num_eval_envs=self.simulations,
            episode_length=self.episode_length,
            batch_size=self.batch_size,
            num_minibatches=MINIBATCHES,
            unroll_length=10,
            num_updates_per_batch=4,
            learning_rate=3e-4,
            entropy_cost=1e-3,
            discounting=0.97,
            normalize_observations=True,
            network_factory=functools.partial(
                networks.make_ppo_networks,
                policy_hidden_layer_sizes=(128, 128),
                value_hidden_layer_sizes=(128, 128),
            ),
            seed=self.seed,
            progress_fn=progress,
        )
        self._write(rows)

    def _write(self, rows: Sequence[tuple[int, float, float]]) -> None:
        lines = ["step,mean,deviation", *(f"{step},{a:.4f},{b:.4f}" for step, a, b in rows)]
        files.write_text(self.out / f"{self.reward}.csv", "\n".join(lines) + "\n")
        steps, means, deviations = zip(*rows, strict=True)
        with canvas.look():
            figure, panels = canvas.grid(1, 1, panel=(4.8, 3.0), legend=[])
            panels[0, 0].errorbar(steps, means, yerr=deviations, capsize=2)
            panels[0, 0].set(xlabel="control steps", ylabel=f"return ({self.reward})")
            canvas.save(figure, self.out / f"{self.reward}.png")
        print(f"{self.reward}.csv and {self.reward}.png are in {self.out}")


if __name__ == "__main__":
    cli.script(Example)
