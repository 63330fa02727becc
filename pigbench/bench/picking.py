"""Whether the scripted policy places cubes, and how far a step differs from MuJoCo in C.

Checks an engine on a device without OGBench and without recordings of it.
"""

# mujoco's compiled modules carry no types.
# pyright: reportAttributeAccessIssue=false

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key

from pigbench import envs, seeds
from pigbench.envs import control
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import PlayPolicy
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import SUBSTEPS, Scene
from pigbench.envs.spec import SUCCESS_DISTANCE

_STATES = 256  # in which a control step is compared, at most


class Picks(NamedTuple):
    """Picks and places, and states and controls sampled from all of them."""

    distances: Float[np.ndarray, "pick"]  # metres from the cube to its target at the plan's end
    diverged: Bool[np.ndarray, "pick"]
    qpos: Float[np.ndarray, "batch nq"]
    qvel: Float[np.ndarray, "batch nv"]
    ctrl: Float[np.ndarray, "batch nu"]

    @property
    def placed(self) -> Bool[np.ndarray, "pick"]:
        """Whether each cube ended at its target."""
        return ~self.diverged & (self.distances < SUCCESS_DISTANCE)


class StepErrors(NamedTuple):
    """Distances from C after one control step: of the farthest joint and the farthest cube."""

    arm: Float[np.ndarray, "batch"]  # radians
    cube: Float[np.ndarray, "batch"]  # metres


def pick_and_place(env: "envs.CubeEnv", count: int) -> Picks:
    """Run the first plan of the policy `play` in `count` random scenes, all at once.

    Cubes of a random scene may touch from the start: not every plan succeeds, nor does it in C.
    """
    policy = PlayPolicy(env.spec, env.scene)

    @jax.jit
    def play(key: Key[Array, ""]):
        scene_key, policy_key = jax.random.split(key)
        begin = jax.vmap(env.random_scene)(jax.random.split(scene_key, count))
        memory = jax.vmap(policy.reset)(jax.random.split(policy_key, count), begin)

        def step(states: PhysicsState, time: Int[Array, ""]):
            now = memory.replace(time=jnp.full(count, time))
            actions = jax.vmap(partial(policy.act, key))(now, states)
            ctrl = jax.vmap(partial(control.servo_targets, env.scene))(states, actions)
            active = time < memory.plan.length
            after = jax.vmap(env.physics.step)(states, ctrl, active)
            return after, (active, states.qpos, states.qvel, ctrl)

        times = jnp.arange(memory.plan.targets.shape[1])
        end, way = jax.lax.scan(step, begin, times)
        cubes = jax.vmap(lambda state: cube_poses(env.scene, state)[0])(end)
        placed = cubes[jnp.arange(count), memory.target.cube]
        distances = jnp.linalg.norm(placed - memory.target.pos, axis=-1)
        return distances, end.diverged, way

    distances, diverged, (active, *way) = jax.device_get(play(seeds.key(3)))
    times, simulations = np.nonzero(active)
    some = np.linspace(0, len(times) - 1, min(_STATES, len(times)), dtype=int)
    return Picks(distances, diverged, *(array[times[some], simulations[some]] for array in way))


def step_errors(env: "envs.CubeEnv", picks: Picks) -> StepErrors:
    """Compare one control step from each state, here and in C."""
    begin = jax.jit(jax.vmap(env.physics.init))(picks.qpos, picks.qvel)
    here = np.asarray(jax.jit(jax.vmap(env.physics.step))(begin, picks.ctrl).qpos)
    there = _in_c(env.scene, picks)
    apart = np.abs(here - there)
    cubes = apart[:, env.scene.cubes_qpos].reshape(len(apart), -1, 7)[..., :3]
    return StepErrors(
        arm=apart[:, env.scene.arm].max(axis=-1),
        cube=np.linalg.norm(cubes, axis=-1).max(axis=-1),
    )


def _in_c(scene: Scene, picks: Picks) -> Float[np.ndarray, "batch nq"]:
    """C's `qpos` after a control step from each state; `mj_forward` precedes controls."""
    data = mujoco.MjData(scene.model)
    ends = []
    for qpos, qvel, ctrl in zip(picks.qpos, picks.qvel, picks.ctrl, strict=True):
        mujoco.mj_resetData(scene.model, data)
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(scene.model, data)
        data.ctrl[:] = ctrl
        mujoco.mj_step(scene.model, data, nstep=SUBSTEPS)
        ends.append(data.qpos.copy())
    return np.array(ends)
