import jax
import pytest
from scipy import stats


def test_the_loss_is_scipys_likelihood(build, init, batch):
    agent = build("gcbc")
    params = init(agent)
    loss, _ = agent.loss(params, {}, batch, jax.random.key(0))
    means = agent.policy.apply(
        params["policy"], observations=batch.observations, goals=batch.actor_goals
    )
    log_probs = stats.norm.logpdf(batch.actions, loc=means).sum(axis=-1)
    assert loss == pytest.approx(-log_probs.mean(), rel=1e-5)
