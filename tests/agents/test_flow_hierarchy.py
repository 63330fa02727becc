import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import (
    FlowCloneConfig,
    FlowHierarchyConfig,
    GCIVLConfig,
    HJBRegularizer,
    Statistics,
)
from pigbench.agents.directions import make
from pigbench.errors import UserError
from pigbench.layout import Layout, Space

SMALL = {"actor_hidden_sizes": (16,), "value_hidden_sizes": (16,)}


@pytest.fixture(scope="module")
def hierarchy(build):
    """H-Flow over GCIVL, whose low level sees the first three of four coordinates."""
    return build("h-flow-gcivl", low=GCIVLConfig(**SMALL), subgoal_steps=3, discount=0.9)


@pytest.fixture(scope="module")
def init(hierarchy):
    """`init(key)`: fresh parameters."""
    return jax.jit(hierarchy.init)


@pytest.fixture(scope="module")
def loss(hierarchy):
    """`loss(params, target_params, batch, key)`, compiled once."""
    return jax.jit(hierarchy.loss)


def cross_entropy(logits, targets):
    p = 1 / (1 + np.exp(-np.asarray(logits)))
    return -(targets * np.log(p) + (1 - targets) * np.log(1 - p))


def test_the_high_levels_values_against_numpy(hierarchy, init, loss, batch):
    """k steps are worth 0.9^k; the first three transitions end at their goals."""
    params, targets = (init(jax.random.key(seed)) for seed in (0, 1))
    subgoals = batch.subgoals
    networks = hierarchy.values

    def value(states):
        return np.asarray(
            networks.value.apply(params["high_value"], observations=states, goals=batch.value_goals)
        )

    def critics(params):
        return [
            np.asarray(
                networks.critic.apply(
                    jax.tree.map(lambda leaf, i=i: leaf[i], params["high_critic"]),
                    observations=batch.observations,
                    actions=subgoals.value_subgoals[:, :3],
                    goals=batch.value_goals,
                )
            )
            for i in range(2)
        ]

    future = 1 / (1 + np.exp(-value(subgoals.value_subgoals)))
    y = [1, 1, 0.9**2, *(0.9**k * v for k, v in zip((3, 3, 1, 3, 3), future[3:], strict=True))]
    critic_loss = sum(cross_entropy(q, np.array(y)).mean() for q in critics(params))
    least = np.min(1 / (1 + np.exp(-np.array(critics(targets)))), axis=0)
    value_loss = cross_entropy(value(batch.observations), least).mean()

    targets = {name: targets[name] for name in hierarchy.target_networks}
    total, metrics = loss(params, targets, batch, jax.random.key(2))
    assert metrics["high_critic/loss"] == pytest.approx(critic_loss, rel=1e-5)
    assert metrics["high_value/loss"] == pytest.approx(value_loss, rel=1e-5)
    parts = ("high_critic/loss", "high_value/loss", "high_actor/loss", "low_actor/loss")
    assert total == pytest.approx(
        sum(float(metrics[part]) for part in parts) + float(metrics["low_value/td_loss"]), rel=1e-5
    )


def test_the_flow_learns_subgoals_on_the_way_to_the_actors_goals(hierarchy, init, loss, batch):
    """With v = 0 the loss is |x_1 - x_0|^2, next to |x_1|^2 for samples far beyond the noise."""
    params = jax.tree.map(jnp.zeros_like, init(jax.random.key(0)))
    targets = {name: params[name] for name in hierarchy.target_networks}
    far = batch.subgoals.replace(actor_subgoals=1e4 * batch.subgoals.actor_subgoals)
    _, metrics = loss(params, targets, batch.replace(subgoals=far), jax.random.key(1))
    expected = (far.actor_subgoals[:, :3] ** 2).sum(axis=-1).mean()
    assert metrics["high_actor/loss"] == pytest.approx(expected, rel=1e-2)


def test_the_low_level_is_the_flat_agent_on_its_representation(hierarchy, init, loss, batch):
    """GCIVL built by hand for three coordinates, with discount 1 - 1/3."""
    flat = agents.build(
        "gcivl",
        GCIVLConfig(**SMALL, discount=1 - 1 / 3),
        Space(Layout.of({"joint_pos": 3}), 2),
    )
    params, targets = (init(jax.random.key(seed)) for seed in (0, 1))
    targets = {name: targets[name] for name in hierarchy.target_networks}
    _, metrics = loss(params, targets, batch, jax.random.key(2))

    subgoals = batch.subgoals
    low = subgoals.low_for_value
    _, expected = jax.jit(flat.loss)(
        {name: params[f"low_{name}"] for name in ("value", "policy")},
        {"value": targets["low_value"]},
        agents.Batch(
            observations=batch.observations[:, :3],
            actions=batch.actions,
            next_observations=batch.next_observations[:, :3],
            actor_goals=subgoals.low_actor_goals[:, :3],
            for_value=low.replace(states=low.states[:, :3]),
        ),
        jax.random.key(0),
    )
    for name, value in expected.items():
        assert metrics[f"low_{name}"] == pytest.approx(float(value), rel=1e-5), name


def test_acts_towards_the_best_candidate_of_each_example(hierarchy, init):
    """Against a loop over examples and candidates; the flow's own samples are tested apart."""
    params = init(jax.random.key(0))
    states, goals = jax.random.normal(jax.random.key(1), (2, 5, 4))
    keys = jax.random.split(jax.random.key(2), 5)
    actions = jax.jit(jax.vmap(hierarchy.act, (None, 0, 0, 0)))(params, states, goals, keys)

    sample = jax.jit(hierarchy.actor.sample, static_argnames="count")
    members = [jax.tree.map(lambda leaf, i=i: leaf[i], params["high_critic"]) for i in range(2)]
    criticise = jax.jit(hierarchy.values.critic.apply)
    for b in range(5):
        candidates = sample(
            params["high_actor"],
            observation=states[b],
            goal=goals[b],
            count=32,
            key=jax.random.split(keys[b])[0],
        )
        logits = [
            [
                criticise(
                    member,
                    observations=states[b],
                    actions=candidates[n],
                    goals=goals[b],
                ).item()
                for member in members
            ]
            for n in range(32)
        ]
        best = candidates[np.argmax(np.min(logits, axis=1))]
        mean = hierarchy.low.policy.apply(
            params["low_policy"], observations=states[b, :3], goals=best
        )
        np.testing.assert_allclose(actions[b], np.clip(mean, -1, 1), rtol=1e-4, atol=1e-6)


def test_standardized_the_levels_see_the_datas_own_scale(batch):
    """As of observations that were standardised beforehand, but for the high level's inputs."""
    mean, deviation = np.array([1.0, -2, 3, 0]), np.array([2.0, 0.5, 4, 1])
    config = FlowHierarchyConfig(**SMALL, low=GCIVLConfig(**SMALL), subgoal_steps=3)
    agent = agents.build(
        "h-flow-gcivl",
        config,
        Space(Layout.of({"joint_pos": 3, "cube_0_pos": 1}), 2),
        statistics=agents.Statistics(mean, deviation),
    )
    states = batch.observations
    expected = ((states - mean) / deviation)[:, :3]
    np.testing.assert_allclose(agent.represent(states), expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(agent.low.statistics.deviation, np.ones(3))
    np.testing.assert_array_equal(agent.low.units, deviation[:3])

    params = jax.jit(agent.init)(jax.random.key(0))
    subgoals = jnp.zeros((8, 3))
    np.testing.assert_allclose(
        jax.vmap(agent.follow, (None, 0, 0, None))(params, states, subgoals, jax.random.key(1)),
        jnp.clip(
            agent.low.policy.apply(params["low_policy"], observations=expected, goals=subgoals),
            -1,
            1,
        ),
        rtol=1e-4,
        atol=1e-6,
    )


@pytest.mark.parametrize("name", ["hiql", "h-flow-gcivl"])
def test_a_low_level_with_subgoals_of_its_own_is_refused(name):
    low = agents.get(name)
    mine = agents.hierarchy("mine", low.agent, low.config, summary="")
    with pytest.raises(UserError, match=r"(HIQL|FlowHierarchy) has subgoals of its own"):
        mine.agent(
            mine.config,
            Space(Layout.of({"joint_pos": 3}), 2),
            statistics=Statistics.standard(3),
        )


def test_standardizing_needs_statistics():
    with pytest.raises(UserError, match="standardize needs the statistics of a data set"):
        agents.build(
            "h-flow-gcivl",
            FlowHierarchyConfig(low=GCIVLConfig()),
            Space(Layout.of({"joint_pos": 3}), 2),
        )


def test_samples_both_levels_goals_by_their_own_rules(hierarchy):
    sampling = hierarchy.sampling
    assert (sampling.discount, sampling.subgoals.steps) == (0.9, 3)
    assert sampling.subgoals.low_discount == pytest.approx(2 / 3)
    assert not sampling.value_goals.geometric
    assert sampling.actor_goals.geometric
    assert sampling.subgoals.low_value_goals == GCIVLConfig().value_goals


def test_every_target_is_a_copy_of_a_network(hierarchy):
    state = jax.eval_shape(partial(agents.create, hierarchy), jax.random.key(0))
    assert set(state.target_params) == {"high_critic", "low_value"}
    assert set(state.params) == {
        "high_actor",
        "high_critic",
        "high_value",
        "low_value",
        "low_policy",
    }


def test_a_setting_without_effect_is_refused():
    for name, value in {"discount": 0.5, "batch_size": 7, "learning_rate": 0.1}.items():
        with pytest.raises(UserError, match=f"^low.{name} has no effect"):
            FlowHierarchyConfig(low=GCIVLConfig(**{name: value}))
    FlowHierarchyConfig(low=GCIVLConfig(expectile=0.7), discount=0.5, batch_size=7)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("subgoal_steps", 1, "subgoal_steps is 1: it must be at least 2"),
        ("candidates", 0, "candidates is 0: it must be at least 1"),
        ("flow_steps", 0, "flow_steps is 0: it must be at least 1"),
        ("low_level_representation", "joints", "unknown representation 'joints'"),
    ],
)
def test_a_value_out_of_range_is_named(field, value, message):
    with pytest.raises(UserError, match=message):
        dataclasses.replace(FlowHierarchyConfig(low=FlowCloneConfig()), **{field: value})


@pytest.mark.parametrize("direction", ["own", "raw"])
def test_motion_is_that_of_the_low_level_in_its_own_coordinates(direction, batch):
    """Of the three that it sees, standardised: dx over its length, or over that of ds."""
    deviation = np.array([1.0, 2.0, 4.0, 8.0], np.float32)
    low = GCIVLConfig(**SMALL, regularizer=HJBRegularizer(direction=direction))
    hierarchy = agents.build(
        "h-flow-gcivl",
        FlowHierarchyConfig(low=low, **SMALL),
        Space(Layout.of({"joint_pos": 3, "cube_0_pos": 1}), 2),
        statistics=Statistics(np.zeros(4, np.float32), deviation),
    )
    moves = (batch.next_observations - batch.observations)[:, :3]
    measured = moves / deviation[:3] if direction == "own" else moves
    expected = moves / deviation[:3] / np.linalg.norm(measured, axis=1, keepdims=True)
    assert hierarchy.penalty.direction == direction
    params = jax.jit(hierarchy.init)(jax.random.key(0))
    learner, _, seen = hierarchy.value_learner(params, batch)
    motion = make(direction, learner.coordinates)
    np.testing.assert_allclose(
        motion(seen.observations, seen.next_observations, epsilon=1e-9), expected, rtol=1e-4
    )
