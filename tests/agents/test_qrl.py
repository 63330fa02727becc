import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats
from scipy.sparse import csgraph

from pigbench import agents
from pigbench.agents import (
    AWRExtraction,
    Batch,
    DDPGBCExtraction,
    EikonalConstraint,
    HJBConstraint,
    QRLConfig,
    TransitionConstraint,
    ValueGoals,
)
from pigbench.errors import UserError
from pigbench.layout import Layout, Space


def covered_length(starts, ends):
    """By counting, at each end point in order, how many intervals are open."""
    total, level, last = 0.0, 0, 0.0
    events = [(x, 1) for x, y in zip(starts, ends, strict=True) if x < y]
    events += [(y, -1) for x, y in zip(starts, ends, strict=True) if x < y]
    for point, change in sorted(events):
        total += (point - last) * (level > 0)
        level, last = level + change, point
    return total


def iqe(x, y):
    """Components of 8, the mixture's logit at 0 as it is at first: (B, n) and (B, n) to (B,)."""
    lengths = np.array(
        [
            [covered_length(*part) for part in zip(a.reshape(-1, 8), b.reshape(-1, 8), strict=True)]
            for a, b in zip(x, y, strict=True)
        ]
    )
    return (lengths.mean(axis=1) + lengths.max(axis=1)) / 2


def expected_violation(kind, distance, states, next_states, h=1e-6):
    """By central differences; `distance` is d(., g)."""
    if kind == "hjb":
        moves = next_states - states
        u = moves / (np.linalg.norm(moves, axis=-1, keepdims=True) + 1e-6)
        return np.mean(((distance(states + h * u) - distance(states - h * u)) / (2 * h) + 1) ** 2)
    axes = h * np.eye(states.shape[-1])
    partials = [(distance(states + axis) - distance(states - axis)) / (2 * h) for axis in axes]
    return np.mean(np.maximum(np.linalg.norm(partials, axis=0) - 1, 0) ** 2)


@pytest.mark.parametrize(
    ("constraint", "actor"),
    [
        (TransitionConstraint(margin=0.2), DDPGBCExtraction(bc_weight=0.7)),
        (EikonalConstraint(margin=0.2), AWRExtraction(temperature=2.0)),
        (HJBConstraint(margin=0.2), DDPGBCExtraction(bc_weight=0.7)),
    ],
)
def test_the_loss_against_numpy(build, init, batch, float64, constraint, actor):
    agent = build(
        "qrl",
        latent_size=16,
        constraint=constraint,
        push_offset=3.0,
        push_beta=0.5,
        actor=actor,
    )
    params = init(agent) | {"multiplier": jnp.log(1.7)}
    # Away from the goals, where d has a kink.
    batch = batch.replace(for_value=ValueGoals(batch.value_goals + 1, batch.value_success))
    s, s_next, g = batch.observations, batch.next_observations, batch.value_goals

    def encode(states):
        inputs = {"observations": states, "method": "encode"}
        return np.asarray(agent.quasimetric.apply(params["value"], **inputs))

    def predict(actions):
        inputs = {"latents": encode(s), "actions": actions}
        return np.asarray(agent.dynamics.apply(params["dynamics"], **inputs))

    push = np.mean(np.log(1 + np.exp(0.5 * (3.0 - iqe(encode(s), encode(g))))) / 0.5)
    if constraint.kind == "transition":
        violation = np.mean(np.maximum(iqe(encode(s), encode(s_next)) - 1, 0) ** 2)
    else:
        violation = expected_violation(
            constraint.kind, lambda x: iqe(encode(x), encode(g)), s, s_next
        )

    means = agent.policy.apply(params["policy"], observations=s, goals=batch.actor_goals)
    log_probs = stats.norm.logpdf(batch.actions, loc=means).sum(axis=-1)
    to_goal = encode(batch.actor_goals)
    if actor.kind == "awr":
        advantages = iqe(encode(s), to_goal) - iqe(encode(s_next), to_goal)
        rest = -np.mean(np.minimum(np.exp(2.0 * advantages), 100) * log_probs)
    else:
        predicted, following = predict(batch.actions), encode(s_next)
        dynamics_loss = np.mean(iqe(predicted, following) + iqe(following, predicted)) / 2
        q = -iqe(predict(np.clip(means, -1, 1)), to_goal)
        rest = dynamics_loss - q.mean() / np.abs(q).mean() - 0.7 * log_probs.mean()

    loss, metrics = jax.jit(agent.loss)(params, {}, batch, jax.random.key(0))
    assert metrics["value/push"] == pytest.approx(push, rel=1e-9)
    assert metrics["dual/violation"] == pytest.approx(violation, rel=1e-5)
    assert metrics["dual/multiplier"] == pytest.approx(1.7)
    # The multiplier's two terms leave lambda times the margin.
    assert loss == pytest.approx(push + 1.7 * 0.2 + rest, rel=1e-5)


def test_the_multiplier_climbs_while_the_constraint_is_violated(build, init, batch):
    """The slope of its logarithm is lambda (margin - violation)."""
    agent = build("qrl", latent_size=16, constraint=TransitionConstraint(margin=0.1))
    params = init(agent)

    def loss(log_multiplier):
        multiplied = params | {"multiplier": log_multiplier}
        return agent.loss(multiplied, {}, batch, jax.random.key(0))

    slope, metrics = jax.jit(jax.grad(loss, has_aux=True))(jnp.log(1.7))
    assert metrics["dual/violation"] > 0.1
    np.testing.assert_allclose(slope, 1.7 * (0.1 - metrics["dual/violation"]), rtol=1e-5)


def test_finds_the_shortest_paths_of_a_graph():
    """A ring of six one-way streets with two short cuts, its nodes one-hot."""
    edges = np.array([(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (0, 3), (4, 1)])
    adjacency = np.zeros((6, 6))
    adjacency[tuple(edges.T)] = 1
    config = QRLConfig(
        learning_rate=5e-3,
        actor_hidden_sizes=(8,),
        value_hidden_sizes=(64,),
        latent_size=64,
        actor=AWRExtraction(),
        constraint=TransitionConstraint(margin=1e-3),
    )
    agent = agents.build("qrl", config, Space(Layout.of({"node": 6}), 1))
    nodes = np.eye(6, dtype=np.float32)
    starts, ends = (nodes[column].repeat(6, axis=0) for column in edges.T)
    goals = np.tile(nodes, (len(edges), 1))
    batch = Batch(
        observations=starts,
        actions=np.zeros((len(starts), 1), np.float32),
        next_observations=ends,
        actor_goals=goals,
        for_value=ValueGoals(goals, np.zeros(len(starts), np.float32)),
    )

    @jax.jit
    def train(key):
        def step(state, _):
            return agents.update(agent, state, batch, key)

        return jax.lax.scan(step, agents.create(agent, key), length=4000)[0].params["value"]

    found = agent.quasimetric.apply(
        train(jax.random.key(0)), observations=nodes[:, None], goals=nodes[None]
    )
    np.testing.assert_allclose(found, csgraph.shortest_path(adjacency), rtol=0.1, atol=0.1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"quasimetric": "ieq"}, "did you mean 'iqe'"),
        ({"latent_size": 12}, "latent_size is 12: it must be a positive multiple of 8"),
        (
            {"latent_size": 7, "quasimetric": "mrn"},
            "latent_size is 7: it must be a positive multiple of 2",
        ),
        ({"push_beta": 0.0}, "push_beta is 0.0: it must be positive"),
    ],
)
def test_bad_fields_are_named(arguments, message):
    with pytest.raises(UserError, match=message):
        QRLConfig(**arguments)
