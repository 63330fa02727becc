import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents.networks import (
    MLP,
    BilinearCritic,
    LatentDynamics,
    Policy,
    Value,
    apply_ensemble,
    init_ensemble,
)


def gelu(x):
    """The tanh form of Hendrycks and Gimpel (2016)."""
    return 0.5 * x * (1 + np.tanh(np.sqrt(2 / np.pi) * (x + 0.044715 * x**3)))


def normalize(x):
    return (x - x.mean(-1, keepdims=True)) / np.sqrt(x.var(-1, keepdims=True) + 1e-6)


@pytest.mark.parametrize("layer_norm", [False, True])
def test_mlp_is_linear_gelu_norm_linear(layer_norm):
    network = MLP((16, 16), 3, layer_norm=layer_norm)
    inputs = np.random.default_rng(0).normal(size=(4, 5)).astype(np.float32)
    params = network.init(jax.random.key(0), inputs)

    features = inputs
    for layer in ("Dense_0", "Dense_1"):
        features = gelu(features @ np.asarray(params["params"][layer]["kernel"]))
        features = normalize(features) if layer_norm else features
    expected = features @ np.asarray(params["params"]["Dense_2"]["kernel"])

    np.testing.assert_allclose(network.apply(params, inputs), expected, atol=1e-5)


@pytest.mark.parametrize(
    ("network", "output_scale"),
    [(Value((512, 512), layer_norm=True), 1.0), (Policy((512, 512), 64), 0.01)],
)
def test_initial_weights_fill_their_interval(network, output_scale):
    """Uniform with variance 2 scale / (fan in + fan out): its bound is sqrt(3) deviations."""
    states = jnp.zeros((1, 100))
    params = network.init(jax.random.key(0), observations=states, goals=states)["params"]["MLP_0"]
    for layer, scale in (("Dense_0", 1.0), ("Dense_1", 1.0), ("Dense_2", output_scale)):
        kernel = np.asarray(params[layer]["kernel"])
        bound = np.sqrt(3 * 2 * scale / sum(kernel.shape))
        assert 0.98 * bound < np.abs(kernel).max() <= bound * (1 + 1e-6)
        assert kernel.std() == pytest.approx(bound / np.sqrt(3), rel=0.05)
        assert not np.any(params[layer]["bias"])


def test_inputs_are_keyword_only():
    states = jnp.zeros((1, 2))
    with pytest.raises(TypeError, match="positional"):
        Value((8,), layer_norm=True).init(jax.random.key(0), states, states)


def test_members_of_an_ensemble_are_networks_of_their_own():
    network = Value((8,), layer_norm=True)
    states = jax.random.normal(jax.random.key(1), (5, 2))
    members = init_ensemble(network, jax.random.key(0), 3, observations=states, goals=states)
    together = apply_ensemble(network, members, observations=states, goals=-states)
    apart = [
        network.apply(
            jax.tree.map(lambda leaf, i=i: leaf[i], members), observations=states, goals=-states
        )
        for i in range(3)
    ]
    np.testing.assert_allclose(together, apart, rtol=1e-5)
    assert not np.allclose(apart[0], apart[1])


def test_a_bilinear_critic_embeds_its_sides_apart():
    """phi is an `MLP` of (s, a) over the root of its size, psi one of g."""
    network = BilinearCritic((8,), 16, layer_norm=True)
    states, actions, goals = jax.random.normal(jax.random.key(1), (3, 5, 2))
    inputs = {"observations": states, "actions": actions, "goals": goals}
    params = network.init(jax.random.key(0), **inputs)
    phi, psi = network.apply(params, **inputs)

    side = MLP((8,), 16, layer_norm=True)
    pairs = jnp.concatenate([states, actions], axis=-1)
    np.testing.assert_allclose(
        phi, side.apply({"params": params["params"]["phi"]}, pairs) / 4, rtol=1e-5
    )
    np.testing.assert_allclose(
        psi, side.apply({"params": params["params"]["psi"]}, goals), rtol=1e-5
    )


def test_latent_dynamics_predict_a_change():
    network = LatentDynamics((8,), layer_norm=True)
    latents, actions = jax.random.normal(jax.random.key(1), (5, 6)), jnp.ones((5, 2))
    params = network.init(jax.random.key(0), latents=latents, actions=actions)
    still = jax.tree.map(lambda leaf: 0 * leaf, params)
    np.testing.assert_array_equal(network.apply(still, latents=latents, actions=actions), latents)
    assert not np.allclose(network.apply(params, latents=latents, actions=actions), latents)
