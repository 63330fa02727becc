import copy
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.experimental.compilation_cache import compilation_cache

from pigbench import agents
from pigbench.agents import Agent, AgentConfig, Batch, TargetConfig, ValueGoals
from pigbench.layout import Layout, Space


class Line(Agent[TargetConfig]):
    """Loss 3 w - 2 b, plus the sum of w's target copy: gradients are 3 and -2 everywhere."""

    target_networks = ("w",)

    def init(self, key):
        return {"w": jnp.ones(2), "b": jnp.zeros(())}

    def loss(self, params, target_params, batch, key):
        loss = 3 * params["w"].sum() - 2 * params["b"] + target_params["w"].sum()
        return loss, {"loss": loss}

    def act(self, params, observation, goal, key):
        return jnp.zeros(self.action_size)


@pytest.fixture
def line():
    config = TargetConfig(learning_rate=0.1, target_rate=0.25)
    return Line(config, Space(Layout.of({"state": 1}), 1))


@pytest.fixture
def gcivl():
    config = agents.GCIVLConfig(actor_hidden_sizes=(8,), value_hidden_sizes=(8,))
    return agents.build("gcivl", config, Space(Layout.of({"state": 3}), 2))


def random_batch(key, size=16):
    normal = partial(jax.random.normal, shape=(size, 3))
    keys = jax.random.split(key, 5)
    return Batch(
        observations=normal(keys[0]),
        actions=normal(keys[1])[:, :2],
        next_observations=normal(keys[2]),
        actor_goals=normal(keys[4]),
        for_value=ValueGoals(normal(keys[3]), (jnp.arange(size) % 5 == 0).astype(jnp.float32)),
    )


def test_two_updates_by_hand(line):
    """Under a constant gradient of any size Adam moves a parameter by its learning rate."""
    key = jax.random.key(0)
    batch = random_batch(key)
    state = agents.create(line, key)
    np.testing.assert_array_equal(state.target_params["w"], 1)

    state, metrics = agents.update(line, state, batch, key)
    np.testing.assert_allclose(state.params["w"], 0.9, rtol=1e-5)
    np.testing.assert_allclose(state.params["b"], 0.1, rtol=1e-5)
    np.testing.assert_allclose(state.target_params["w"], 0.75 * 1 + 0.25 * 0.9, rtol=1e-5)
    assert metrics["loss"] == 3 * 2 + 2
    assert state.step == 1

    state, _ = agents.update(line, state, batch, key)
    np.testing.assert_allclose(state.params["w"], 0.8, rtol=1e-5)
    np.testing.assert_allclose(state.target_params["w"], 0.75 * 0.975 + 0.25 * 0.8, rtol=1e-5)
    assert state.step == 2


def test_an_agent_may_have_its_own_target_rate(line):
    class Fast(Line):
        target_rate = 1.0

    own, given = (
        Fast(config, Space(Layout.of({"state": 1}), 1)) for config in (AgentConfig(), line.config)
    )
    assert (own.target_rate, given.target_rate) == (1.0, 0.25)
    key = jax.random.key(0)
    state, _ = agents.update(own, agents.create(own, key), random_batch(key), key)
    np.testing.assert_array_equal(state.target_params["w"], state.params["w"])


def test_an_average_acts_where_the_agent_averages(line):
    """Its rate is 1, then 10 / 11, and so on down to the agent's own."""
    key = jax.random.key(0)
    batch = random_batch(key)
    assert agents.create(line, key).average == {}

    averaged = copy.copy(line)
    averaged.average_rate = 0.9
    state, expected = agents.create(averaged, key), 0.0
    for step, rate in enumerate((1, 10 / 11, 0.9, 0.9)):
        state, _ = agents.update(averaged, state, batch, key)
        expected += rate * (0.1 * (step + 1) - expected)
        np.testing.assert_allclose(state.acting["b"], expected, rtol=1e-5)
    np.testing.assert_allclose(state.params["b"], 0.4, rtol=1e-5)

    line.average_rate = 1.0
    state, _ = agents.update(line, agents.create(line, key), batch, key)
    assert state.acting is state.params


def test_targets_are_not_under_the_optimiser(line):
    state = agents.create(line, jax.random.key(0))
    assert set(state.target_params) == {"w"}
    moments = state.opt_state[0]
    assert jax.tree.structure(moments.mu) == jax.tree.structure(state.params)


@pytest.fixture
def uncached():
    """What is compiled is compiled here, whatever the session keeps."""

    def keep(programs: bool) -> None:
        jax.config.update("jax_enable_compilation_cache", programs)
        compilation_cache.reset_cache()

    keep(False)
    yield
    keep(True)


def test_equal_arguments_give_equal_bits(gcivl, uncached):
    """Two compilations, each scanned over three steps and mapped over two seeds."""
    batch = random_batch(jax.random.key(1))

    def train(key):
        return jax.lax.scan(
            lambda state, key: agents.update(gcivl, state, batch, key),
            agents.create(gcivl, key),
            jax.random.split(key, 3),
        )

    keys = jax.random.split(jax.random.key(7))
    first = jax.jit(jax.vmap(train))(keys)
    jax.clear_caches()
    second = jax.jit(jax.vmap(train))(keys)
    for left, right in zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True):
        assert left.tobytes() == right.tobytes()
    np.testing.assert_array_equal(first[0].step, 3)


def test_a_state_can_be_donated(gcivl):
    """No two leaves share a buffer, so training may update in place."""
    step = jax.jit(partial(agents.update, gcivl), donate_argnums=0)
    state, _ = step(
        agents.create(gcivl, jax.random.key(0)), random_batch(jax.random.key(1)), jax.random.key(2)
    )
    assert state.step == 1
