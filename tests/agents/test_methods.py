"""What every registered method must do: learn a small task, and train on from where it was."""

import dataclasses
from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import AgentConfig
from pigbench.data import sampler
from pigbench.layout import Layout, Space

SPACE = Space(Layout.of({"joint_pos": 2}), 2)
"""Any representation keeps the joints, so all of a point's state."""


def point_mass_rows(episodes=1500):
    """A point in the square [-5, 5]^2 that moves by its action; noisy walks to random targets."""
    rng = np.random.default_rng(0)
    states, actions, terminals = [], [], []
    for _ in range(episodes):
        state, target = rng.uniform(-5, 5, size=(2, 2))
        arrived = False
        while not arrived:
            arrived = np.abs(target - state).max() < 0.5
            action = np.clip(target - state + 0.3 * rng.normal(size=2), -1, 1)
            states.append(state)
            actions.append(action)
            terminals.append(arrived)
            state = np.clip(state + action, -5, 5)
    return sampler.Rows.create(np.float32(states), np.float32(actions), terminals)


TINY = {
    "actor_hidden_sizes": (64, 64),
    "value_hidden_sizes": (64, 64),
    "latent_size": 64,
    "subgoal_steps": 3,
}


def tiny(config):
    """The configuration, and those nested in it, with networks and horizons of the task's size."""
    fields = {field.name: getattr(config, field.name) for field in dataclasses.fields(config)}
    nested = {name: tiny(value) for name, value in fields.items() if isinstance(value, AgentConfig)}
    return dataclasses.replace(
        config, **{name: size for name, size in TINY.items() if name in fields}, **nested
    )


OPTIMIZED = {"xla_backend_optimization_level": 1}
"""Training runs long enough here to pay for a better program than other tests need."""


@cache
def build(name):
    """The agent, its state at first, and a function that trains a state for a number of steps."""
    config = dataclasses.replace(
        tiny(agents.get(name).config), batch_size=128, discount=0.95, learning_rate=1e-3
    )
    rows = point_mass_rows()
    agent = agents.build(
        name,
        config,
        SPACE,
        statistics=agents.Statistics.of(rows.observations),
    )

    def update(_, state):
        keys = jax.random.split(jax.random.fold_in(jax.random.key(1), state.step))
        batch = sampler.sample(keys[0], rows, agent.sampling, config.batch_size)
        return agents.update(agent, state, batch, keys[1])[0]

    @partial(jax.jit, compiler_options=OPTIMIZED)
    def train(state, count):
        return jax.lax.fori_loop(0, count, update, state)

    return agent, jax.jit(partial(agents.create, agent))(jax.random.key(0)), train


@pytest.mark.parametrize("name", agents.names())
def test_reaches_goals_of_a_point_mass(name):
    agent, state, train = build(name)
    params = train(state, 1000).params

    @jax.jit
    def distances(key):
        starts, goals = jax.random.uniform(key, (2, 100, 2), minval=-4.5, maxval=4.5)

        def move(states, key):
            states = jnp.clip(states + agent.act(params, states, goals, key), -5, 5)
            return states, jnp.linalg.norm(states - goals, axis=-1)

        return jax.lax.scan(move, starts, jax.random.split(key, 30))[1]

    reached = (distances(jax.random.key(2)) < 0.5).any(axis=0)
    assert reached.mean() >= 0.8


@pytest.mark.parametrize("name", agents.names())
def test_actions_are_bounded(name):
    agent, state, _ = build(name)
    states = 100 * jax.random.normal(jax.random.key(1), (7, 2))
    actions = jax.jit(agent.act)(state.params, states, -states, jax.random.key(2))
    assert np.all(np.abs(actions) <= 1)


@pytest.mark.parametrize("name", agents.names())
def test_trains_on_to_the_same_bits(name):
    _, state, train = build(name)
    whole, resumed = train(state, 6), train(train(state, 3), 3)
    for left, right in zip(jax.tree.leaves(whole), jax.tree.leaves(resumed), strict=True):
        assert left.tobytes() == right.tobytes()
    assert whole.step == 6
