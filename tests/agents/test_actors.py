import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.agents import actors

MEANS = jnp.array([[0.5, -2.0], [0.0, 0.25], [-0.5, 1.0]])
ACTIONS = jnp.array([[1.0, -1.0], [0.0, 0.5], [0.0, 0.0]])
LOG_PROBS = stats.norm.logpdf(ACTIONS, loc=MEANS).sum(axis=-1)


def test_clone_is_scipys_likelihood():
    loss, metrics = actors.clone(MEANS, ACTIONS)
    assert loss == pytest.approx(-LOG_PROBS.mean(), rel=1e-6)
    assert metrics["actor/mse"] == pytest.approx(np.mean((ACTIONS - MEANS) ** 2))


def test_awr_by_hand():
    """Weights e^(2 A): 1, e and, cut short, 100."""
    loss, metrics = actors.awr(MEANS, ACTIONS, jnp.array([0.0, 0.5, 9.0]), temperature=2.0)
    assert loss == pytest.approx(-np.mean([1, np.e, 100] * LOG_PROBS), rel=1e-6)
    assert metrics["actor/advantage"] == pytest.approx(9.5 / 3)


def test_ddpg_bc_by_hand():
    """The critic sees clipped means: it values them -0.5, 0.25 and 0.5, of mean size 1.25 / 3."""
    loss, _ = actors.ddpg_bc(MEANS, ACTIONS, lambda actions: actions.sum(axis=-1), bc_weight=0.3)
    assert loss == pytest.approx(-0.25 / 1.25 - 0.3 * LOG_PROBS.mean(), rel=1e-5)


def test_ddpg_bc_climbs_the_critic_at_any_scale():
    """Each of the two inner coordinates gains 1 / 3 of a value, over the values' mean size."""

    def slopes(scale):
        def loss(means):
            return actors.ddpg_bc(
                means, ACTIONS, lambda actions: scale * actions.sum(axis=-1), bc_weight=0.0
            )[0]

        return jax.grad(loss)(MEANS)

    expected = np.full((3, 2), -1 / 1.25)
    expected[0, 1] = 0.0  # beyond the action's limit
    expected[2, 1] = slopes(1.0)[2, 1]  # on the limit: either slope will do
    np.testing.assert_allclose(slopes(1.0), expected, rtol=1e-5)
    np.testing.assert_allclose(slopes(1e4), slopes(1.0), rtol=1e-5)
    assert not np.any(slopes(0.0))


def test_the_policy_acts_within_its_limits(build, init):
    agent = build("gcbc")
    params = init(agent)
    states = 1e4 * jax.random.normal(jax.random.key(0), (64, 4))
    means = agent.means(params, states, -states)
    actions = jax.vmap(agent.act, (None, 0, 0, None))(params, states, -states, jax.random.key(1))
    assert np.abs(means).max() > 1
    np.testing.assert_array_equal(actions, np.clip(means, -1, 1))


@pytest.mark.parametrize("name", ["gcbc", "gcivl", "gciql", "crl", "qrl"])
def test_an_actors_goals_train_the_policy_alone(build, init, batch, moved, name):
    agent = build(name)
    params = init(agent)
    targets = {network: params[network] for network in agent.target_networks}
    elsewhere = batch.replace(actor_goals=batch.actor_goals + 1)
    assert moved(agent, params, (targets, batch), (targets, elsewhere)) == {"policy"}
