import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import FlowClone, FlowCloneConfig
from pigbench.errors import UserError
from pigbench.layout import Layout, Space


@pytest.fixture
def clone():
    """`clone(candidates)`: the low level alone, on four coordinates."""

    def clone(candidates):
        config = FlowCloneConfig(
            actor_hidden_sizes=(16,),
            value_hidden_sizes=(16,),
            discount=0.9,
            candidates=candidates,
        )
        return FlowClone(config, Space(Layout.of({"state": 4}), 2))

    return clone


def test_clones_the_actions_given_the_actors_goals(clone, batch):
    """With v = 0 the loss is |a - x_0|^2, next to |a|^2 for actions far beyond the noise."""
    agent = clone(1)
    params = jax.tree.map(jnp.zeros_like, agent.init(jax.random.key(0)))
    far = batch.replace(actions=1e4 * batch.actions)
    loss, metrics = agent.loss(params, {}, far, jax.random.key(1))
    assert set(metrics) == {"actor/loss"}
    assert loss == pytest.approx((far.actions**2).sum(axis=-1).mean(), rel=1e-2)

    params = agent.init(jax.random.key(0))
    original, other_value_goals, other_actor_goals = (
        agent.loss(params, {}, changed, jax.random.key(1))[0]
        for changed in (
            batch,
            batch.replace(value_goals=-batch.value_goals),
            batch.replace(actor_goals=-batch.actor_goals),
        )
    )
    assert original == other_value_goals
    assert original != other_actor_goals


def test_its_critic_backs_up_one_step_or_none_at_the_goal(clone, batch):
    """The first two transitions start at their goals: 1 there, else 0.9 V(s', g)."""
    agent = clone(8)
    params = agent.init(jax.random.key(0))
    targets = {"critic": params["critic"]}
    _, metrics = agent.loss(params, targets, batch, jax.random.key(1))

    def sigmoid(x):
        return 1 / (1 + np.exp(-np.asarray(x)))

    next_values = sigmoid(
        agent.values.value.apply(
            params["value"], observations=batch.next_observations, goals=batch.value_goals
        )
    )
    y = np.array([1.0, 1.0, *(0.9 * next_values[2:])])
    expected = 0.0
    for i in range(2):
        q = sigmoid(
            agent.values.critic.apply(
                jax.tree.map(lambda leaf, i=i: leaf[i], params["critic"]),
                observations=batch.observations,
                actions=batch.actions,
                goals=batch.value_goals,
            )
        )
        expected -= (y * np.log(q) + (1 - y) * np.log(1 - q)).mean()
    assert metrics["critic/loss"] == pytest.approx(expected, rel=1e-5)


def test_a_single_candidate_needs_no_critic(clone):
    assert set(agents.create(clone(1), jax.random.key(0)).params) == {"actor"}
    state = agents.create(clone(2), jax.random.key(0))
    assert set(state.params) == {"actor", "critic", "value"}
    assert set(state.target_params) == {"critic"}


def test_acts_by_the_candidate_its_critic_scores_highest(clone):
    agent = clone(6)
    params = agent.init(jax.random.key(0))
    states, goals = jax.random.normal(jax.random.key(1), (2, 5, 4))
    keys = jax.random.split(jax.random.key(2), 5)
    actions = jax.vmap(agent.act, (None, 0, 0, 0))(params, states, goals, keys)
    for b in range(5):
        drawn = agent.actor.sample(
            params["actor"], observation=states[b], goal=goals[b], count=6, key=keys[b]
        )
        candidates = np.clip(drawn, -1, 1)
        scores = [
            agent.values.score(
                params, observations=states[b], actions=candidate, goals=goals[b]
            ).item()
            for candidate in candidates
        ]
        np.testing.assert_allclose(actions[b], candidates[np.argmax(scores)], rtol=1e-5)


def test_a_value_out_of_range_is_named():
    with pytest.raises(UserError, match="candidates is 0: it must be at least 1"):
        FlowCloneConfig(candidates=0)
