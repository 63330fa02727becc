import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import agents
from pigbench.data import sampler
from pigbench.agents import Batch, GCIVLConfig, Regularizer

OBSERVATION_SIZE, ACTION_SIZE = 4, 2


def build(**fields):
    config = GCIVLConfig(actor_hidden_sizes=(16,), value_hidden_sizes=(16,), **fields)
    return agents.build(
        "gcivl",
        config,
        observation_size=OBSERVATION_SIZE,
        action_size=ACTION_SIZE,
        layout={},
    )


def random_batch(rng, size=8):
    observations = rng.normal(size=(size, OBSERVATION_SIZE))
    value_goals = rng.normal(size=(size, OBSERVATION_SIZE))
    value_goals[:2] = observations[:2]
    return Batch(
        observations=observations,
        actions=rng.uniform(-1, 1, size=(size, ACTION_SIZE)),
        next_observations=observations + 0.3 * rng.normal(size=observations.shape),
        value_goals=value_goals,
        value_success=np.array([1.0, 1.0] + [0.0] * (size - 2)),
        actor_goals=rng.normal(size=(size, OBSERVATION_SIZE)),
    )


def member_values(agent, members, states, goals):
    """(B, 2), one member of the ensemble at a time."""
    columns = [
        agent.value.apply(
            jax.tree.map(lambda leaf, i=i: leaf[i], members), observations=states, goals=goals
        )
        for i in range(2)
    ]
    return np.stack(columns, axis=-1)


def expected_td_loss(values, target_values, target_next_values, success, discount, iota):
    total = 0.0
    for b in range(len(success)):
        reward, mask = (0.0, 0.0) if success[b] else (-1.0, 1.0)
        y = reward + discount * mask * min(target_next_values[b])
        weight = iota if y - sum(target_values[b]) / 2 >= 0 else 1 - iota
        for i in range(2):
            y_i = reward + discount * mask * target_next_values[b][i]
            total += weight * (y_i - values[b][i]) ** 2
    return total / len(success)


def expected_regularization(kind, value, states, next_states, h=1e-5):
    """Residuals by central differences, summed over the members and averaged over the batch."""
    if kind == "none":
        return 0.0
    if kind == "hjb":
        moves = next_states - states
        u = moves / (np.linalg.norm(moves, axis=-1, keepdims=True) + 1e-6)
        cost_slopes = -(value(states + h * u) - value(states - h * u)) / (2 * h)
        return ((cost_slopes + 1) ** 2).sum(axis=-1).mean()
    axes = h * np.eye(OBSERVATION_SIZE)
    partials = [(value(states + axis) - value(states - axis)) / (2 * h) for axis in axes]
    return ((np.linalg.norm(partials, axis=0) - 1) ** 2).sum(axis=-1).mean()


def expected_actor_loss(values, next_values, actions, means, temperature):
    total = 0.0
    for b in range(len(actions)):
        advantage = sum(next_values[b]) / 2 - sum(values[b]) / 2
        weight = min(np.exp(temperature * advantage), 100)
        density = np.exp(-((actions[b] - means[b]) ** 2) / 2) / np.sqrt(2 * np.pi)
        total -= weight * np.log(density).sum()
    return total / len(actions)


@pytest.mark.parametrize("kind", ["none", "eikonal", "hjb"])
def test_the_loss_against_numpy(kind):
    with jax.enable_x64(True):
        agent = build(discount=0.9, expectile=0.8, regularizer=Regularizer(kind, weight=0.7))
        params, other = (
            jax.tree.map(
                lambda leaf: leaf.astype(jnp.float64), jax.jit(agent.init)(jax.random.key(seed))
            )
            for seed in (0, 1)
        )
        targets = other["value"]
        batch = random_batch(np.random.default_rng(0))

        def value(states, goals, members=params["value"]):
            return member_values(agent, members, states, goals)

        s, s_next, g = batch.observations, batch.next_observations, batch.value_goals
        td_loss = expected_td_loss(
            value(s, g),
            value(s, g, targets),
            value(s_next, g, targets),
            batch.value_success,
            discount=0.9,
            iota=0.8,
        )
        regularization = 0.7 * expected_regularization(kind, lambda x: value(x, g), s, s_next)
        actor_loss = expected_actor_loss(
            value(s, batch.actor_goals),
            value(s_next, batch.actor_goals),
            batch.actions,
            agent.policy.apply(params["policy"], observations=s, goals=batch.actor_goals),
            temperature=10.0,
        )

        loss, metrics = jax.jit(agent.loss)(params, {"value": targets}, batch, jax.random.key(0))
        assert metrics["value/td_loss"] == pytest.approx(td_loss, rel=1e-9)
        assert metrics["value/regularization"] == pytest.approx(regularization, rel=1e-6)
        assert metrics["actor/loss"] == pytest.approx(actor_loss, rel=1e-9)
        assert loss == pytest.approx(td_loss + regularization + actor_loss, rel=1e-6)


def test_the_actor_loss_trains_the_policy_alone():
    agent = build()
    params = jax.jit(agent.init)(jax.random.key(0))
    batch = random_batch(np.random.default_rng(0))
    targets = {"value": params["value"]}

    @jax.jit
    def gradients(batch):
        return jax.grad(agent.loss, has_aux=True)(params, targets, batch, jax.random.key(0))[0]

    before = gradients(batch)
    after = gradients(batch.replace(actor_goals=batch.actor_goals + 1, actions=-batch.actions))
    changes = jax.tree.map(lambda left, right: jnp.abs(left - right).max(), before, after)
    assert max(jax.tree.leaves(changes["value"])) < 1e-5
    assert min(jax.tree.leaves(changes["policy"])) > 1e-3


def point_mass_rows(episodes=200, length=40):
    """A point in the square [-5, 5]^2 that moves by its action, on walks that turn now and then.

    A step of full speed has length 1 or more, so all three methods' assumptions roughly hold.
    """
    rng = np.random.default_rng(0)
    states = [rng.uniform(-5, 5, size=(episodes, 2))]
    heading = rng.uniform(-1, 1, size=(episodes, 2))
    actions = []
    for _ in range(length):
        turn = rng.uniform(size=(episodes, 1)) < 0.2
        heading = np.where(turn, rng.uniform(-1, 1, size=(episodes, 2)), heading)
        actions.append(heading)
        states.append(np.clip(states[-1] + heading, -5, 5))
    rows = (np.stack(column[:length], axis=1).reshape(-1, 2) for column in (states, actions))
    terminals = np.tile(np.arange(length) == length - 1, episodes)
    return sampler.Rows.create(*(column.astype(np.float32) for column in rows), terminals)


@pytest.mark.parametrize("name", ["gcivl", "eik-gcivl", "hjb-gcivl"])
def test_reaches_goals_of_a_point_mass(name):
    rows = point_mass_rows()
    config = GCIVLConfig(
        actor_hidden_sizes=(64, 64),
        value_hidden_sizes=(64, 64),
        learning_rate=1e-3,
        discount=0.95,
        regularizer=agents.get(name).config.regularizer,
    )
    agent = agents.build(name, config, observation_size=2, action_size=2, layout={})

    def step(state, key):
        batch = sampler.sample(key, rows, agent.sampling, 256)
        return agents.update(agent, state, batch, key)

    @jax.jit
    def train_and_act(key):
        state = agents.create(agent, key)
        state, _ = jax.lax.scan(step, state, jax.random.split(key, 2000))
        starts, goals = jax.random.uniform(key, (2, 100, 2), minval=-4.5, maxval=4.5)

        def move(states, _):
            states += agent.act(state.params, states, goals, key)
            return jnp.clip(states, -5, 5), jnp.linalg.norm(states - goals, axis=-1)

        return jax.lax.scan(move, starts, length=30)[1]

    reached = (train_and_act(jax.random.key(0)) < 0.5).any(axis=0)
    assert reached.mean() >= 0.8
