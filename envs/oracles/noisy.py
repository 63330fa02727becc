"""The `noisy` policy: OGBench's Markov oracle with noisy actions, target after target."""

from dataclasses import replace

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from pigbench.envs import trees, workspace
from pigbench.envs.observation import cube_poses, gripper_contact
from pigbench.envs.oracles import markov, targets
from pigbench.envs.oracles.policy import ScriptedPolicy
from pigbench.envs.physics import PhysicsState
from pigbench.envs.rotations import quat_yaw
from pigbench.envs.units import ACTION_SIZE

MAX_NOISE = 0.1  # an episode's noise level is drawn uniformly between 0 and this
NOISE_SCALE = (1.0, 1.0, 1.0, 3.0, 10.0)  # deviation per noise level of x, y, z, yaw and gripper


@struct.dataclass
class NoisyState:
    """The policy's memory between control steps of one episode."""

    stacking: Float[Array, ""]  # probability, fixed for the episode
    noise: Float[Array, ""]  # level, fixed for the episode
    target: targets.Target
    final: markov.Pose
    time: Int[Array, ""]  # control steps since the target was drawn
    done: Bool[Array, ""]  # whether the cube and the arm are where they should be


class NoisyPolicy(ScriptedPolicy[NoisyState]):
    """Moves cubes to one target after another."""

    def reset(self, key: PRNGKeyArray, physics_state: PhysicsState) -> NoisyState:
        """Begin an episode."""
        stacking_key, noise_key, key = jax.random.split(key, 3)
        stacking = self.draw_stacking(stacking_key)
        noise = jax.random.uniform(noise_key, maxval=MAX_NOISE)
        first = jnp.asarray(targets.FIRST_STACKING)
        return self._begin(key, physics_state, stacking, noise, next_stacking=first)

    def act(
        self, key: PRNGKeyArray, state: NoisyState, physics_state: PhysicsState
    ) -> Float[Array, "action"]:
        """The oracle's action with noise, in [-1, 1]."""
        intended = markov.action(self._look(physics_state, state.target), state.target, state.final)
        noise = state.noise * jnp.array(NOISE_SCALE) * jax.random.normal(key, (ACTION_SIZE,))
        return jnp.clip(intended + noise, -1.0, 1.0)

    def advance(
        self, key: PRNGKeyArray, state: NoisyState, physics_state: PhysicsState
    ) -> NoisyState:
        """Continue after the action, or draw the next target if this sub-task has ended."""
        fresh = self._begin(key, physics_state, state.stacking, state.noise, state.stacking)
        going_on = replace(
            state,
            time=state.time + 1,
            done=markov.done(self._look(physics_state, state.target), state.target, state.final),
        )
        ended = self.ended(state)
        return trees.where(ended, fresh, going_on)

    def ended(self, state: NoisyState) -> Bool[Array, ""]:
        """Whether the current action is the sub-task's last."""
        return state.done | (state.time >= markov.MAX_STEPS - 1)

    def _begin(
        self,
        key: PRNGKeyArray,
        physics_state: PhysicsState,
        stacking: Float[Array, ""],
        noise: Float[Array, ""],
        next_stacking: Float[Array, ""],
    ) -> NoisyState:
        target_key, pos_key, yaw_key = jax.random.split(key, 3)
        target = targets.draw(target_key, cube_poses(self.scene, physics_state)[0], next_stacking)
        final = markov.Pose(
            pos=workspace.PINCH_START.sample(pos_key),
            yaw=jax.random.uniform(yaw_key, minval=-jnp.pi, maxval=jnp.pi),
        )
        done = markov.done(self._look(physics_state, target), target, final)
        return NoisyState(stacking, noise, target, final, jnp.zeros((), jnp.int32), done)

    def _look(self, physics_state: PhysicsState, target: targets.Target) -> markov.OracleInputs:
        positions, quats = cube_poses(self.scene, physics_state)
        return markov.OracleInputs(
            effector_pos=physics_state.pinch_pos,
            effector_yaw=physics_state.pinch_yaw,
            contact=gripper_contact(physics_state),
            cube_pos=positions[target.cube],
            cube_yaw=quat_yaw(quats[target.cube]),
        )
