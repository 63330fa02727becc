import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs.environment import CubeEnv
from pigbench.evaluation.settings import Evaluation
from pigbench.fidelity import closed_loop, peer
from pigbench.fidelity.closed_loop import Successes


@pytest.mark.parametrize(
    ("counts", "p"),
    [
        ((3, 2, 8, 1), 2 * (1 + 10 + 45) / 2**10),
        ((3, 8, 2, 1), 2 * (1 + 10 + 45) / 2**10),
        ((0, 4, 0, 5), 2 / 2**4),
        ((7, 3, 3, 0), 1.0),
        ((5, 0, 0, 5), 1.0),
    ],
)
def test_mcnemars_test_by_hand(counts, p):
    ends = np.repeat([[True, True], [True, False], [False, True], [False, False]], counts, axis=0)
    ours, theirs = np.random.default_rng(0).permutation(ends).T
    comparison = closed_loop.compare(Successes(ours, theirs))
    assert comparison[:4] == counts
    assert comparison.p == pytest.approx(p)


class Noisy:
    """A policy with noise from its keys."""

    def __init__(self, policy):
        self.policy = policy

    def act(self, params, observation, goal, key):
        noise = 0.5 * jax.random.normal(key, (5,))
        return jnp.clip(self.policy.act(params, observation, goal, key) + noise, -1, 1)


def test_the_same_noisy_policy_ends_alike_in_both_simulators(scripted):
    single = envs.make("cube-single")
    tasks = single.spec.tasks[1:3]
    # Long enough for some episodes and too short for others.
    spec = dataclasses.replace(single.spec, tasks=tasks, episode_length=60)
    env = CubeEnv(spec, single.physics)
    reports = []
    successes = closed_loop.simulate(
        env, Noisy(scripted(env.layout)), jnp.asarray(1.0), Evaluation(5, seed=1), reports.append
    )
    assert reports == list(range(1, 11))
    assert successes.ours.shape == (2, 5)
    # One of ten may lie on the edge; with other draws in one of them, three differ.
    assert (successes.ours != successes.theirs).sum() <= 1
    assert 2 <= successes.ours.sum() <= 8


def test_a_placed_scene_looks_as_ours():
    env = envs.make("cube-double")
    state = jax.jit(env.reset_task)(jax.random.key(3), 5)
    simulator = peer.make("cube-double", mode="task")
    with peer.quiet():
        simulator.reset(seed=0, options={"task_id": 2})
    target = np.asarray(state.info["target"])
    observation = peer.place(simulator, np.asarray(state.pipeline_state.qpos), target)
    np.testing.assert_allclose(observation, state.obs, atol=1e-4)
    _, _, _, _, info = simulator.step(np.zeros(5))
    assert not info["success"]
    there = np.array(state.pipeline_state.qpos)
    for index, cube in enumerate(target):
        there[14 + 7 * index :][:3] = cube
    peer.place(simulator, there, target)
    _, _, _, _, info = simulator.step(np.zeros(5))
    assert info["success"]
