"""The `play` policy: one plan after another, each for a random cube and target."""

from dataclasses import replace

import jax
import jax.numpy as jnp
from flax import struct
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from pigbench.envs import control, trees
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import plan, targets
from pigbench.envs.oracles.policy import ScriptedPolicy
from pigbench.envs.physics import PhysicsState
from pigbench.envs.rotations import quat_yaw


@struct.dataclass
class PlayState:
    """The policy's memory between control steps of one episode."""

    stacking: Float[Array, ""]  # probability, fixed for the episode
    target: targets.Target
    plan: plan.Plan
    time: Int[Array, ""]  # control steps since the plan began


class PlayPolicy(ScriptedPolicy[PlayState]):
    """Follows one plan after another."""

    def reset(self, key: PRNGKeyArray, physics_state: PhysicsState) -> PlayState:
        """Begin an episode."""
        stacking_key, key = jax.random.split(key)
        stacking = self.draw_stacking(stacking_key)
        first = targets.FIRST_STACKING
        return self._begin(key, physics_state, stacking, next_stacking=jnp.asarray(first))

    def act(
        self, key: PRNGKeyArray, state: PlayState, physics_state: PhysicsState
    ) -> Float[Array, "action"]:
        """The action in [-1, 1] that follows the plan. `key` is unused."""
        now = jnp.minimum(state.time, state.plan.length - 1)
        return control.action_towards(self.scene, physics_state, state.plan.targets[now])

    def advance(
        self, key: PRNGKeyArray, state: PlayState, physics_state: PhysicsState
    ) -> PlayState:
        """Continue after the action, or begin the next plan if this one has ended."""
        going_on = replace(state, time=state.time + 1)
        ended = self.ended(state)
        fresh = self._begin(key, physics_state, state.stacking, next_stacking=state.stacking)
        return trees.where(ended, fresh, going_on)

    def ended(self, state: PlayState) -> Bool[Array, ""]:
        """Whether the current action is the plan's last."""
        return state.time >= state.plan.length - 1

    def _begin(
        self,
        key: PRNGKeyArray,
        physics_state: PhysicsState,
        stacking: Float[Array, ""],
        next_stacking: Float[Array, ""],
    ) -> PlayState:
        target_key, plan_key = jax.random.split(key)
        positions, quats = cube_poses(self.scene, physics_state)
        target = targets.draw(target_key, positions, next_stacking)
        new_plan = plan.make(
            plan_key,
            control.effector(self.scene, physics_state),
            positions[target.cube],
            quat_yaw(quats[target.cube]),
            target,
        )
        return PlayState(stacking, target, new_plan, jnp.zeros((), jnp.int32))
