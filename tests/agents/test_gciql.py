import jax
import numpy as np
import pytest
from scipy import stats


def member_critics(agent, members, states, actions, goals):
    """(2, B), one member of the ensemble at a time."""
    return np.stack(
        [
            agent.critic.apply(
                jax.tree.map(lambda leaf, i=i: leaf[i], members),
                observations=states,
                actions=actions,
                goals=goals,
            )
            for i in range(2)
        ]
    )


def test_the_loss_against_numpy(build, init, batch, float64):
    agent = build("gciql", discount=0.9, expectile=0.8, bc_weight=0.7)
    params, targets = init(agent), {"critic": init(agent, 1)["critic"]}
    s, a, s_next, g = batch.observations, batch.actions, batch.next_observations, batch.value_goals

    def value(states):
        return agent.value.apply(params["value"], observations=states, goals=g)

    gaps = member_critics(agent, targets["critic"], s, a, g).min(axis=0) - value(s)
    value_loss = np.mean([(0.8 if gap >= 0 else 0.2) * gap**2 for gap in gaps])

    reached = batch.value_success == 1
    backups = np.where(reached, 0.0, -1.0 + 0.9 * value(s_next))
    errors = member_critics(agent, params["critic"], s, a, g) - backups
    critic_loss = (errors[0] ** 2 + errors[1] ** 2).mean()

    means = agent.policy.apply(params["policy"], observations=s, goals=batch.actor_goals)
    q = member_critics(agent, params["critic"], s, np.clip(means, -1, 1), batch.actor_goals).min(
        axis=0
    )
    log_probs = stats.norm.logpdf(a, loc=means).sum(axis=-1)
    actor_loss = -q.mean() / np.abs(q).mean() - 0.7 * log_probs.mean()

    loss, metrics = jax.jit(agent.loss)(params, targets, batch, jax.random.key(0))
    assert metrics["value/loss"] == pytest.approx(value_loss, rel=1e-9)
    assert metrics["critic/loss"] == pytest.approx(critic_loss, rel=1e-9)
    assert metrics["actor/loss"] == pytest.approx(actor_loss, rel=1e-5)
    assert loss == pytest.approx(value_loss + critic_loss + actor_loss, rel=1e-5)


def test_value_and_critic_have_a_loss_each(build, init, batch, moved):
    """The critic backs up what follows, and the value regresses to the critic's target copy."""
    agent = build("gciql")
    params = init(agent)
    targets = {"critic": params["critic"]}
    doubled = jax.tree.map(lambda leaf: 2 * leaf, targets)
    elsewhere = batch.replace(next_observations=-batch.observations)
    assert moved(agent, params, (targets, batch), (targets, elsewhere)) == {"critic"}
    assert moved(agent, params, (targets, batch), (doubled, batch)) == {"value"}
