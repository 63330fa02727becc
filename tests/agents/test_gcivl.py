import jax
import numpy as np
import pytest

from pigbench.agents import EikonalRegularizer, HJBRegularizer, NoRegularizer


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
    axes = h * np.eye(states.shape[-1])
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


@pytest.mark.parametrize(
    "regularizer", [NoRegularizer(), EikonalRegularizer(weight=0.7), HJBRegularizer(weight=0.7)]
)
def test_the_loss_against_numpy(build, init, batch, float64, regularizer):
    agent = build("gcivl", discount=0.9, expectile=0.8, regularizer=regularizer)
    params, targets = init(agent), init(agent, 1)["value"]

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
    regularization = 0.7 * expected_regularization(
        regularizer.kind, lambda x: value(x, g), s, s_next
    )
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


@pytest.mark.parametrize("regularizer", [NoRegularizer(), HJBRegularizer()])
def test_a_reward_at_the_goal_gives_the_same_values_on_another_scale(
    build, batch, float64, regularizer
):
    """1 + (1 - discount) V: errors are (1 - discount) as large, and residuals are the same.

    The value's last layer does it, being linear.
    """
    cost, reward = (
        build("gcivl", discount=0.9, rewards=rewards, regularizer=regularizer)
        for rewards in ("-1/0", "0/1")
    )
    params = cost.init(jax.random.key(0))

    def rescaled(path, leaf):
        names = [part.key for part in path]
        if names[0] != "value" or "Dense_1" not in names:
            return leaf
        return 0.1 * leaf + (1 if names[-1] == "bias" else 0)

    scaled = jax.tree_util.tree_map_with_path(rescaled, params)
    (_, of_cost), (_, of_reward) = (
        agent.loss(values, {"value": values["value"]}, batch, jax.random.key(0))
        for agent, values in ((cost, params), (reward, scaled))
    )
    states, goals = batch.observations, batch.value_goals
    rewarded, costly = (jax.vmap(one.state_value, (None, 0, 0)) for one in (reward, cost))
    np.testing.assert_allclose(
        rewarded(scaled, states, goals), costly(params, states, goals), rtol=1e-5
    )
    of_cost, of_reward = jax.device_get((of_cost, of_reward))
    assert of_reward["value/mean"] == pytest.approx(1 + 0.1 * of_cost["value/mean"], rel=1e-9)
    assert of_reward["value/td_loss"] == pytest.approx(0.01 * of_cost["value/td_loss"], rel=1e-6)
    assert of_reward["value/residual"] == pytest.approx(of_cost["value/residual"], rel=1e-6)


def test_normalized_actors_have_layers_for_it(build):
    layers = {
        normalized: set(
            build("gcivl", actor_layer_norm=normalized).init(jax.random.key(0))["policy"]["params"][
                "MLP_0"
            ]
        )
        for normalized in (False, True)
    }
    assert layers[True] - layers[False] == {"LayerNorm_0"}
