import jax
import numpy as np
import pytest
from scipy import stats


def member_logits(agent, members, states, actions, goals):
    """f_i of every pair (s, a) with every goal, (2, B, B), one pair at a time."""
    logits = np.empty((2, len(states), len(goals)))
    for i in range(2):
        phi, psi = agent.critic.apply(
            jax.tree.map(lambda leaf, i=i: leaf[i], members),
            observations=states,
            actions=actions,
            goals=goals,
        )
        for j, k in np.ndindex(logits.shape[1:]):
            logits[i, j, k] = phi[j] @ psi[k]
    return logits


def test_the_loss_against_numpy(build, init, batch, float64):
    agent = build("crl", latent_size=8, bc_weight=0.7)
    params = init(agent)
    s, a = batch.observations, batch.actions

    logits = member_logits(agent, params["critic"], s, a, batch.value_goals)
    p = 1 / (1 + np.exp(-logits))
    own = np.eye(len(s), dtype=bool)
    critic_loss = -np.where(own, np.log(p), np.log(1 - p)).mean()

    means = agent.policy.apply(params["policy"], observations=s, goals=batch.actor_goals)
    f = member_logits(agent, params["critic"], s, np.clip(means, -1, 1), batch.actor_goals)
    q = np.array([np.diag(member) for member in f]).min(axis=0)
    log_probs = stats.norm.logpdf(a, loc=means).sum(axis=-1)
    actor_loss = -q.mean() / np.abs(q).mean() - 0.7 * log_probs.mean()

    loss, metrics = jax.jit(agent.loss)(params, {}, batch, jax.random.key(0))
    assert metrics["critic/loss"] == pytest.approx(critic_loss, rel=1e-9)
    assert metrics["critic/own_goal"] == pytest.approx(logits[:, own].mean(), rel=1e-9)
    assert metrics["actor/loss"] == pytest.approx(actor_loss, rel=1e-5)
    assert loss == pytest.approx(critic_loss + actor_loss, rel=1e-5)
