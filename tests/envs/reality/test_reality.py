"""The robot's environment beside the one that it is without its reality."""

from dataclasses import fields, replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs.reality import REAL, PoseEstimate, Reality, Variation
from pigbench.envs.units import metres
from pigbench.errors import UserError

pytestmark = pytest.mark.usefixtures("users_emitters")

COUNT, STEPS = 4, 6
KEYS = jax.random.split(jax.random.key(0), COUNT)
START, GOAL = jnp.array([[0.4, 0.05, 0.02]]), jnp.array([[0.425, 0.0, 0.02]])
ACTIONS = jax.random.uniform(jax.random.key(1), (STEPS, COUNT, 5), minval=-1, maxval=1)


NO_ERRORS = -1e-9, float("nan"), float("inf")
NO_PROBABILITIES = (*NO_ERRORS, 1.001)
NO_DELAYS = -1, 1.5, float("nan")
WRONG = {
    PoseEstimate: dict.fromkeys(
        ["position_noise", "yaw_noise", "position_bias", "yaw_bias"], NO_ERRORS
    )
    | dict.fromkeys(["misregistration_bias", "occlusion_distance"], NO_ERRORS)
    | dict.fromkeys(["misregistration", "dropout", "occluded_dropout"], NO_PROBABILITIES)
    | {"latency": NO_DELAYS},
    Variation: dict.fromkeys(["friction", "mass"], (*NO_ERRORS, 1.0)),
    Reality: {"action_delay": NO_DELAYS},
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_cannot_be_is_refused(kind):
    for name, values in WRONG[kind].items():
        for value in values:
            with pytest.raises(UserError, match=f"{name} is {value}: it must be "):
                kind(**{name: value})
    numbers = {field.name for field in fields(kind) if field.name not in ("estimate", "variation")}
    assert WRONG[kind].keys() == numbers


def test_the_ends_of_the_ranges_are_accepted():
    PoseEstimate(misregistration=1.0, dropout=1.0, occluded_dropout=1.0, latency=np.int64(0))
    Variation(friction=0.999, mass=0.0)


def roll(env, actions=ACTIONS):
    """The states of COUNT episodes, (STEPS + 1, COUNT, ...)."""

    @jax.jit
    def run(keys, actions):
        first = jax.vmap(lambda key: env.reset_to(key, START, GOAL))(keys)

        def step(state, action):
            after = jax.vmap(env.step)(state, action)
            return after, after

        return first, jax.lax.scan(step, first, actions)[1]

    first, rest = run(KEYS, actions)
    return jax.tree.map(lambda one, others: jnp.concatenate([one[None], others]), first, rest)


@pytest.fixture(scope="module")
def single(env):
    return roll(env("cube-single"))


def same_bytes(one, other) -> bool:
    return np.asarray(one).tobytes() == np.asarray(other).tobytes()


def test_all_zero_is_cube_single_to_the_bit(env, single):
    zero = envs.make("cube-centre", reality=Reality())
    states = roll(zero)
    for name, part in zero.layout.items():
        assert same_bytes(states.obs[..., part], single.obs[..., env("cube-single").layout[name]])
    assert same_bytes(states.reward, single.reward)
    assert same_bytes(states.done, single.done)
    ours, theirs = states.pipeline_state, single.pipeline_state
    assert same_bytes(replace(ours, factors=None).qvel, theirs.qvel)
    assert all(
        map(same_bytes, jax.tree.leaves(replace(ours, factors=None)), jax.tree.leaves(theirs))
    )


def test_an_action_is_carried_out_later(env, single):
    late = envs.make("cube-centre", reality=Reality(action_delay=2))
    still = jnp.zeros_like(ACTIONS[:2])
    states = roll(late, ACTIONS)
    expected = roll(env("cube-single"), jnp.concatenate([still, ACTIONS[:-2]]))
    assert same_bytes(states.pipeline_state.qpos, expected.pipeline_state.qpos)
    assert not same_bytes(states.pipeline_state.qpos, single.pipeline_state.qpos)


def test_the_robot_is_seen_and_the_cube_is_estimated(env):
    real = env("cube-centre")
    states = roll(real)
    scene, layout = real.scene, real.layout
    qpos = np.asarray(states.pipeline_state.qpos)
    assert same_bytes(states.obs[..., layout["joint_pos"]], qpos[..., scene.arm])
    error = metres(np.asarray(states.obs[..., layout["cube_0_pos"]]))
    error = error - qpos[..., scene.cubes_qpos][..., :3]
    assert 0.001 < np.median(np.abs(error)) < 0.01
    assert "effector_pos" not in layout
    # Whether a goal is reached does not depend on what is known of it.
    assert same_bytes(
        states.info["goal"], roll(envs.make("cube-centre", reality=Reality())).info["goal"]
    )


def test_a_state_that_is_done_stays_as_it_is(env):
    real = env("cube-centre")
    reset = jax.jit(lambda key: real.reset_to(key, GOAL, GOAL, jitter=0.0))
    step = jax.jit(real.step)
    done = step(reset(KEYS[0]), jnp.zeros(5))
    assert done.done
    after = step(done, jnp.ones(5))
    for one, other in zip(jax.tree.leaves(done), jax.tree.leaves(after), strict=True):
        assert same_bytes(one, other)


def test_noise_may_be_put_around_any_environment():
    noisy = envs.make("cube-double", reality=replace(REAL, action_delay=0))
    assert noisy.layout.keys() >= {"effector_pos", "cube_1_pos"}
    states = jax.jit(noisy.reset)(KEYS[0])
    assert states.info["senses"].track.known.shape == (2, 7)
