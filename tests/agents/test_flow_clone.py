import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.agents import BestOfFlow, BestOfFlowConfig, FlowClone, FlowCloneConfig
from pigbench.errors import UserError
from pigbench.layout import Layout, Space

SPACE = Space(Layout.of({"state": 4}), 2)


@pytest.fixture
def clone():
    """The low level of SHARSA alone, on four coordinates."""
    return FlowClone(FlowCloneConfig(actor_hidden_sizes=(16,)), SPACE)


@pytest.fixture
def best():
    """`best(candidates)`: the low level of DSHARSA alone."""

    def best(candidates):
        config = BestOfFlowConfig(
            actor_hidden_sizes=(16,),
            value_hidden_sizes=(16,),
            discount=0.9,
            candidates=candidates,
        )
        return BestOfFlow(config, SPACE)

    return best


def test_clones_the_actions_given_the_actors_goals(clone, batch):
    """With v = 0 the loss is |a - x_0|^2, next to |a|^2 for actions far beyond the noise."""
    agent = clone
    params = jax.tree.map(jnp.zeros_like, agent.init(jax.random.key(0)))
    far = batch.replace(actions=1e4 * batch.actions)
    loss, metrics = agent.loss(params, {}, far, jax.random.key(1))
    assert set(metrics) == {"actor/loss"}
    assert loss == pytest.approx((far.actions**2).sum(axis=-1).mean(), rel=1e-2)

    params = agent.init(jax.random.key(0))
    original, without_value_goals, other_actor_goals = (
        agent.loss(params, {}, changed, jax.random.key(1))[0]
        for changed in (
            batch,
            batch.replace(for_value=None),
            batch.replace(actor_goals=-batch.actor_goals),
        )
    )
    assert original == without_value_goals
    assert original != other_actor_goals


def test_its_critic_backs_up_one_step_or_none_at_the_goal(best, batch):
    """The first two transitions start at their goals: 1 there, else 0.9 V(s', g)."""
    agent = best(8)
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


def test_the_best_of_several_needs_a_critic_besides_the_same_flow(clone, best, batch):
    flow, state = (agents.create(agent, jax.random.key(0)) for agent in (clone, best(2)))
    assert set(flow.params) == {"actor"}
    assert set(state.params) == {"actor", "critic", "value"}
    assert set(state.target_params) == {"critic"}
    for left, right in zip(
        jax.tree.leaves(flow.params["actor"]), jax.tree.leaves(state.params["actor"]), strict=True
    ):
        np.testing.assert_array_equal(left, right)
    of_flow, of_all = (
        agent.loss(one.params, one.target_params, batch, jax.random.key(1))[1]["actor/loss"]
        for agent, one in ((clone, flow), (best(2), state))
    )
    assert of_flow == of_all


def test_acts_by_the_candidate_its_critic_scores_highest(best):
    agent = best(6)
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
    with pytest.raises(UserError, match="flow_steps is 0: it must be at least 1"):
        FlowCloneConfig(flow_steps=0)
    with pytest.raises(UserError, match="candidates is 1: it must be at least 2"):
        BestOfFlowConfig(candidates=1)
