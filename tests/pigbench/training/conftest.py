"""A short environment of an easy and a hard task, and an agent that acts at random."""

import dataclasses

import jax
import pytest

from pigbench import envs
from pigbench.envs.environment import CubeEnv
from pigbench.envs.tasks import Task

SOLVED = Task("solved", ((0.4, 0.0),), ((0.4, 0.0),))
FAR = Task("far", ((0.4, 0.2),), ((0.4, -0.2),))


class Drawn:
    """An agent whose actions are random."""

    def act(self, params, observation, goal, key):
        return jax.random.uniform(key, (5,), minval=-1, maxval=1)


@pytest.fixture
def drawn() -> Drawn:
    return Drawn()


@pytest.fixture(scope="session")
def env() -> CubeEnv:
    single = envs.make("cube-single")
    spec = dataclasses.replace(single.spec, tasks=(SOLVED, FAR), episode_length=6)
    return CubeEnv(spec, single.physics)
