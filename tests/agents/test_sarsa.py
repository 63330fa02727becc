import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from pigbench.agents.sarsa import Sarsa


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def cross_entropy(logits, targets):
    return -(targets * np.log(sigmoid(logits)) + (1 - targets) * np.log(sigmoid(-logits)))


def members(values, params, **inputs):
    """The logits of Q_1 and Q_2, (2, B), one member at a time."""
    return [
        np.asarray(
            values.critic.apply(jax.tree.map(lambda leaf, i=i: leaf[i], params["critic"]), **inputs)
        )
        for i in range(2)
    ]


def test_the_loss_against_numpy(float64):
    rng = np.random.default_rng(0)
    states, next_states, goals = rng.normal(size=(3, 6, 4))
    actions = rng.normal(size=(6, 2))
    success = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    discounts = 0.9 ** np.array([0, 2, 3, 3, 1, 3])

    values = Sarsa((16,), layer_norm=True)
    inputs = {"observations": states, "actions": actions, "goals": goals}
    params, targets = (values.init(jax.random.key(seed), **inputs) for seed in (0, 1))

    next_value = sigmoid(
        np.asarray(values.value.apply(params["value"], observations=next_states, goals=goals))
    )
    y = [discounts[b] * (1.0 if success[b] else next_value[b]) for b in range(6)]
    critic_loss = sum(
        cross_entropy(q, np.array(y)).mean() for q in members(values, params, **inputs)
    )
    least = np.minimum(*map(sigmoid, members(values, targets, **inputs)))
    v = np.asarray(values.value.apply(params["value"], observations=states, goals=goals))
    value_loss = cross_entropy(v, least).mean()

    def total(params):
        return values.loss(
            params,
            targets,
            **inputs,
            next_observations=next_states,
            success=success,
            discounts=discounts,
        )

    loss, metrics = total(params)
    assert metrics["critic/loss"] == pytest.approx(critic_loss, rel=1e-5)
    assert metrics["value/loss"] == pytest.approx(value_loss, rel=1e-5)
    assert loss == pytest.approx(critic_loss + value_loss, rel=1e-5)

    # The last bias' gradient of a cross-entropy is sigmoid(logit) - target: V at s alone has one.
    gradient = jax.grad(lambda params: total(params)[0])(params)["value"]
    bias = gradient["params"]["MLP_0"]["Dense_1"]["bias"]
    np.testing.assert_allclose(bias, [(sigmoid(v) - least).mean()], rtol=1e-4)


@pytest.mark.parametrize("stride", [1, 3])
def test_finds_the_discounted_steps_to_the_end_of_a_chain(stride):
    """One-hot states and linear networks, so a table; every state is followed by the next."""
    length, discount = 8, 0.8
    states = np.arange(length)
    ends = np.minimum(states + stride, length - 1)
    one_hot = jnp.eye(length)
    transitions = {
        "observations": one_hot[states],
        "actions": one_hot[ends],
        "next_observations": one_hot[ends],
        "goals": jnp.zeros((length, length)),
        "success": jnp.asarray(ends == length - 1, jnp.float32),
        "discounts": jnp.asarray(discount ** (ends - states)),
    }
    values = Sarsa((), layer_norm=False)
    inputs = {name: transitions[name] for name in ("observations", "actions", "goals")}
    params = values.init(jax.random.key(0), **inputs)
    optimizer = optax.adam(0.05)

    def step(carry, _):
        params, targets, opt_state = carry
        gradients = jax.grad(lambda params: values.loss(params, targets, **transitions)[0])(params)
        updates, opt_state = optimizer.update(gradients, opt_state)
        params = optax.apply_updates(params, updates)
        targets = optax.incremental_update({"critic": params["critic"]}, targets, 0.1)
        return (params, targets, opt_state), None

    start = (params, {"critic": params["critic"]}, optimizer.init(params))
    (params, _, _), _ = jax.jit(lambda carry: jax.lax.scan(step, carry, length=3000))(start)

    expected = discount ** (length - 1 - states)
    found = jax.nn.sigmoid(
        values.value.apply(params["value"], observations=one_hot, goals=transitions["goals"])
    )
    # The end's value is 1, which logits only tend to.
    np.testing.assert_allclose(found, expected, atol=0.02)
    np.testing.assert_allclose(values.score(params, **inputs), expected, atol=0.02)


def test_scores_of_many_candidates_are_those_of_each():
    values = Sarsa((8,), layer_norm=False)
    states = jax.random.normal(jax.random.key(0), (3, 4))
    candidates = jax.random.normal(jax.random.key(1), (5, 3, 2))
    params = values.init(
        jax.random.key(2), observations=states, actions=candidates[0], goals=states
    )
    scores = values.score(params, observations=states, actions=candidates, goals=-states)
    for n, b in np.ndindex(5, 3):
        logits = members(
            values, params, observations=states[b], actions=candidates[n, b], goals=-states[b]
        )
        np.testing.assert_allclose(scores[n, b], sigmoid(np.array(logits)).min(), rtol=1e-5)


def test_the_best_candidate_is_that_of_each_example():
    """Mapped over three examples, against a loop over examples and candidates."""
    rng = np.random.default_rng(0)
    states, goals = rng.normal(size=(2, 3, 4))
    candidates = rng.normal(size=(3, 5, 2))
    values = Sarsa((16,), layer_norm=True)
    params = values.init(
        jax.random.key(0), observations=states, actions=candidates[:, 0], goals=goals
    )

    def best(state, goal, drawn):
        return values.best(params, observation=state, goal=goal, candidates=drawn)

    found = jax.vmap(best)(states, goals, candidates)
    for b in range(3):
        scores = [
            values.score(params, observations=states[b], actions=one, goals=goals[b]).item()
            for one in candidates[b]
        ]
        np.testing.assert_allclose(found[b], candidates[b, np.argmax(scores)], rtol=1e-6)
