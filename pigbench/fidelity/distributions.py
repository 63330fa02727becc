"""Whether data of a scripted policy and OGBench's of the same policy have the same distribution."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Key, Shaped

from pigbench import envs, seeds
from pigbench.data import collect
from pigbench.data.collect import Simulation
from pigbench.envs import workspace
from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.envs.observation import cube_poses, gripper_contact
from pigbench.envs.oracles import POLICIES, ScriptedPolicy
from pigbench.envs.oracles.targets import ON_TOP_DISTANCE
from pigbench.envs.scene import Scene
from pigbench.envs.spec import SUCCESS_DISTANCE
from pigbench.errors import lookup
from pigbench.fidelity.recording import PeerRecording
from pigbench.fidelity.replay import TOUCH

_CELL = 0.05  # metres, cell size of the grid in which the workspace's coverage is counted
_LEVEL = 0.01  # metres by which a resting cube may be higher or lower than an edge's length


class ScriptedEpisode(NamedTuple):
    """One episode from either source: NumPy arrays, or JAX's in simulation."""

    cubes: Float[Array | np.ndarray, "time cube 3"]  # metres
    pinch: Float[Array | np.ndarray, "time 3"]  # metres
    contact: Float[Array | np.ndarray, "time"]
    actions: Float[Array | np.ndarray, "time action"]
    ended: Bool[Array | np.ndarray, "time"]  # the sub-task ended with this step
    success: Bool[Array | np.ndarray, "time"]  # its cube is then at its target


Values = Shaped[Array | np.ndarray, "value"]


class Comparison(NamedTuple):
    """A quantity's means in both, and the two-sample Kolmogorov-Smirnov test of episodes' means.

    The episode is the unit, since values within an episode are not independent.
    """

    theirs: float
    ours: float
    statistic: float
    p_value: float


def _duration(episode: ScriptedEpisode) -> Values:
    return np.diff(np.flatnonzero(episode.ended), prepend=-1)


def _success(episode: ScriptedEpisode) -> Values:
    return episode.success[episode.ended]


def _stacked(episode: ScriptedEpisode) -> Values:
    """Whether some cube rests on another, per control step."""
    offset = episode.cubes[:, :, None] - episode.cubes[:, None]
    near = np.linalg.norm(offset[..., :2], axis=-1) < ON_TOP_DISTANCE
    on_top = np.abs(offset[..., 2] - 2 * CUBE_HALF_SIZE) < _LEVEL
    return (near & on_top).any(axis=(1, 2))


def _coverage(episode: ScriptedEpisode) -> Values:
    """The share of the workspace's cells that the pinch point visited."""
    low, high = np.array(workspace.PINCH.low), np.array(workspace.PINCH.high)
    shape = np.ceil((high - low) / _CELL).astype(int)
    cells = np.floor((np.clip(episode.pinch, low, high) - low) / _CELL).astype(int)
    visited = np.unique(np.minimum(cells, shape - 1), axis=0)
    return np.array([len(visited) / shape.prod()])


QUANTITIES: Mapping[str, Callable[[ScriptedEpisode], Values]] = {
    "height of the highest cube (m)": lambda episode: episode.cubes[..., 2].max(axis=-1),
    "a cube on another": _stacked,
    "gripper touches": lambda episode: episode.contact > TOUCH,
    "duration of a sub-task (steps)": _duration,
    "success of a sub-task": _success,
    "norm of the move's action": lambda episode: np.linalg.norm(episode.actions[:, :3], axis=-1),
    "size of the yaw's action": lambda episode: np.abs(episode.actions[:, 3]),
    "size of the gripper's action": lambda episode: np.abs(episode.actions[:, 4]),
    "share of the workspace visited": _coverage,
}
"""Name -> the quantity's values in an episode."""


def compare(
    theirs: Sequence[ScriptedEpisode], ours: Sequence[ScriptedEpisode]
) -> dict[str, Comparison]:
    """Compare every quantity that varies at all, by name.

    Episodes in which a quantity has no value, such as a sub-task that never ends, do not count.
    """
    from scipy import stats  # takes long

    comparisons = {}
    for name, quantity in QUANTITIES.items():
        one, other = (
            np.array([values.mean() for values in map(quantity, episodes) if values.size])
            for episodes in (theirs, ours)
        )
        if not (one.size and other.size) or np.ptp(np.concatenate([one, other])) == 0:
            continue
        test: Any = stats.ks_2samp(one, other)
        comparisons[name] = Comparison(one.mean(), other.mean(), test.statistic, test.pvalue)
    return comparisons


def of_recording(scene: Scene, recording: PeerRecording) -> ScriptedEpisode:
    """A recorded episode from OGBench."""
    poses = recording.qpos[:-1, scene.cubes_qpos].reshape(-1, scene.num_cubes, 7)
    return ScriptedEpisode(
        cubes=poses[..., :3],
        pinch=recording.pinch_pos[:-1],
        contact=recording.contact[:-1],
        actions=recording.actions,
        ended=recording.ended,
        success=recording.success,
    )


def simulate(
    env: "envs.CubeEnv", policy_name: str, *, episodes: int, steps: int, seed: int
) -> list[ScriptedEpisode]:
    """Simulate episodes of the named policy in our simulation."""
    policy: ScriptedPolicy[Any] = lookup("policy", POLICIES, policy_name)(env.spec, env.scene)

    def step(simulation: Simulation) -> tuple[Simulation, ScriptedEpisode]:
        before, target = simulation.world.physics, simulation.memory.target
        ended = policy.ended(simulation.memory)
        simulation, row = collect.step(env, policy, simulation)
        after = cube_poses(env.scene, simulation.world.physics)[0][target.cube]
        return simulation, ScriptedEpisode(
            cubes=cube_poses(env.scene, before)[0],
            pinch=before.pinch_pos,
            contact=gripper_contact(before),
            actions=row["actions"],
            ended=ended,
            success=jnp.linalg.norm(after - target.pos) <= SUCCESS_DISTANCE,
        )

    @jax.jit
    def run(keys: Key[Array, "episode"]) -> ScriptedEpisode:
        simulations = jax.vmap(lambda key: collect.begin(env, policy, key, jnp.zeros((), bool)))(
            keys
        )
        return jax.lax.scan(lambda batch, _: jax.vmap(step)(batch), simulations, length=steps)[1]

    rows = jax.device_get(run(jax.random.split(seeds.key(seed), episodes)))
    return [jax.tree.map(lambda x: x[:, number], rows) for number in range(episodes)]  # noqa: B023
