import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.agents import HIQLConfig
from pigbench.agents.hiql import on_sphere
from pigbench.errors import UserError


def test_on_sphere():
    np.testing.assert_allclose(on_sphere(jnp.array([3.0, 4.0])), np.sqrt(2) * np.array([0.6, 0.8]))


def test_the_origin_has_no_direction_but_a_finite_gradient():
    origin = jnp.zeros(3)
    np.testing.assert_array_equal(on_sphere(origin), 0)
    assert jnp.isfinite(jax.jacobian(on_sphere)(origin)).all()


def represent(agent, params, states, goals):
    """phi from the perceptron inside it: its output at length sqrt(n)."""
    phi = agent.representation.apply(params["representation"], observations=states, goals=goals)
    np.testing.assert_allclose(np.linalg.norm(phi, axis=-1), np.sqrt(phi.shape[-1]), rtol=1e-6)
    return np.asarray(phi)


def member_values(agent, params, states, goals, members=None):
    """(B, 2), one member of the ensemble at a time."""
    members = params["value"] if members is None else members
    columns = [
        agent.value.apply(
            jax.tree.map(lambda leaf, i=i: leaf[i], members),
            observations=states,
            goals=represent(agent, params, states, goals),
        )
        for i in range(2)
    ]
    return np.stack(columns, axis=-1)


def awr_loss(advantages, actions, means, temperature):
    weights = np.minimum(np.exp(temperature * advantages), 100)
    return -(weights * stats.norm.logpdf(actions, loc=means).sum(axis=-1)).mean()


def test_the_loss_against_numpy(build, init, batch, float64):
    agent = build("hiql", discount=0.9, expectile=0.8, high_temperature=2.0, low_temperature=5.0)
    params, targets = init(agent, 0), init(agent, 1)["value"]
    s, s_next, g = batch.observations, batch.next_observations, batch.value_goals

    v = member_values(agent, params, s, g)
    target_v = member_values(agent, params, s, g, targets)
    target_next_v = member_values(agent, params, s_next, g, targets)
    td_loss = 0.0
    for b in range(8):
        reward, mask = (0.0, 0.0) if batch.value_success[b] else (-1.0, 1.0)
        advantage = reward + 0.9 * mask * min(target_next_v[b]) - sum(target_v[b]) / 2
        weight = 0.8 if advantage >= 0 else 0.2
        for i in range(2):
            td_loss += weight * (reward + 0.9 * mask * target_next_v[b, i] - v[b, i]) ** 2 / 8

    def advantage(states, next_states, goals):
        values = (member_values(agent, params, x, goals) for x in (next_states, states))
        return np.subtract(*(value.mean(axis=-1) for value in values))

    near, subgoal, g = (
        batch.subgoals.low_actor_goals,
        batch.subgoals.actor_subgoals,
        batch.actor_goals,
    )
    low_loss = awr_loss(
        advantage(s, s_next, near),
        batch.actions,
        agent.low_policy.apply(
            params["low_policy"], observations=s, goals=represent(agent, params, s, near)
        ),
        temperature=5.0,
    )
    high_loss = awr_loss(
        advantage(s, subgoal, g),
        represent(agent, params, s, subgoal),
        agent.high_policy.apply(params["high_policy"], observations=s, goals=g),
        temperature=2.0,
    )

    loss, metrics = jax.jit(agent.loss)(params, {"value": targets}, batch, jax.random.key(0))
    assert metrics["value/td_loss"] == pytest.approx(td_loss, rel=1e-6)
    assert metrics["low_actor/loss"] == pytest.approx(low_loss, rel=1e-6)
    assert metrics["high_actor/loss"] == pytest.approx(high_loss, rel=1e-6)
    assert loss == pytest.approx(td_loss + low_loss + high_loss, rel=1e-6)


def test_the_policies_train_neither_the_value_nor_the_representation(build, init, batch):
    agent = build("hiql")
    params = init(agent)

    @jax.jit
    def gradients(batch):
        return jax.grad(agent.loss, has_aux=True)(
            params, {"value": params["value"]}, batch, jax.random.key(0)
        )[0]

    before = gradients(batch)
    after = gradients(batch.replace(actor_goals=batch.actor_goals + 1, actions=-batch.actions))
    changes = jax.tree.map(lambda left, right: jnp.abs(left - right).max(), before, after)
    for name in ("value", "representation"):
        assert max(jax.tree.leaves(changes[name])) < 1e-5
    for name in ("high_policy", "low_policy"):
        assert max(jax.tree.leaves(changes[name])) > 1e-3


def test_acts_by_the_low_policy_on_the_high_ones_subgoal(build, init):
    agent = build("hiql")
    params = init(agent)
    states, goals = jax.random.normal(jax.random.key(0), (2, 5, 4))
    means = np.asarray(
        agent.high_policy.apply(params["high_policy"], observations=states, goals=goals)
    )
    subgoals = means / np.sqrt((means**2).mean(axis=-1, keepdims=True))
    expected = agent.low_policy.apply(params["low_policy"], observations=states, goals=subgoals)
    actions = jax.vmap(agent.act, (None, 0, 0, None))(params, states, goals, jax.random.key(1))
    np.testing.assert_allclose(actions, np.clip(expected, -1, 1), rtol=1e-4, atol=1e-6)


def test_defaults_are_ogbenchs():
    config = HIQLConfig()
    assert (config.expectile, config.high_temperature, config.low_temperature) == (0.7, 3.0, 3.0)
    assert (config.subgoal_steps, config.representation_size) == (10, 10)


def test_a_value_out_of_range_is_named():
    with pytest.raises(UserError, match="subgoal_steps is 0: it must be at least 1"):
        HIQLConfig(subgoal_steps=0)
