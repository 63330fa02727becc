"""Scripted policies of cube-double in our simulator; a test module names its own as `policy`."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.envs.observation import cube_poses
from pigbench.envs.spec import SUCCESS_DISTANCE

NAME = "cube-double"


@pytest.fixture(scope="module")
def begun(env, policy):
    """Scenes and the policy's memory at the start of 64 episodes."""

    def begin(key):
        scene_key, policy_key = jax.random.split(key)
        physics_state = env(NAME).random_scene(scene_key)
        return physics_state, policy.reset(policy_key, physics_state)

    return jax.jit(jax.vmap(begin))(jax.random.split(jax.random.key(0), 64))


@pytest.fixture
def our_successes(env, policy):
    """`our_successes(episodes, steps)`: by episode, whether each sub-task ended in success.

    That is: when it ended, its cube was at its target.
    """
    one = env(NAME)

    def step(carry, _):
        key, physics_state, memory = carry
        key, act_key, advance_key = jax.random.split(key, 3)
        after = one.simulate(physics_state, policy.act(act_key, memory, physics_state))
        position = cube_poses(one.scene, after)[0][memory.target.cube]
        success = jnp.linalg.norm(position - memory.target.pos) <= SUCCESS_DISTANCE
        carry = (key, after, policy.advance(advance_key, memory, after))
        return carry, (policy.ended(memory), success)

    def roll_out(episodes: int, steps: int) -> list[np.ndarray]:
        def episode(key):
            scene_key, policy_key, key = jax.random.split(key, 3)
            physics_state = one.random_scene(scene_key)
            carry = (key, physics_state, policy.reset(policy_key, physics_state))
            (_, final, _), outcome = jax.lax.scan(step, carry, length=steps)
            return final.diverged, outcome

        keys = jax.random.split(jax.random.key(7), episodes)
        diverged, (ended, success) = jax.device_get(jax.jit(jax.vmap(episode))(keys))
        assert not diverged.any()
        return [row[at] for row, at in zip(success, ended, strict=True)]

    return roll_out
