"""Regression of a cost-to-go under a regulariser, with all seeds in parallel."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Float, Int, Key

from pigbench.agents.directions import Coordinates
from pigbench.agents.networks import MLP
from pigbench.agents.regularizers import (
    EikonalRegularizer,
    HJBRegularizer,
    NoRegularizer,
    Regularizer,
)
from pigbench.agents.residuals import Transitions
from pigbench.layout import Layout
from pigbench.seeds import key as seed_key
from pigbench.shapes import Array
from pigbench.toy.problem import Costs, Mode, States
from pigbench.toy.settings import Settings

LOSSES: Mapping[str, Regularizer] = {
    "baseline": NoRegularizer(),
    "hjb": HJBRegularizer(),
    "eikonal": EikonalRegularizer(),
}
"""Regression, alone and with each residual: the three losses of the paper's appendix "Extended
analysis of the hybrid toy example"."""

_PLANE = Coordinates(Layout.of({"positions": 2}), statistics=None)

_STRETCH = 100  # updates between two reports


def predict(settings: Settings, params: Any, number: int, states: States) -> Costs:
    """The network's d(s, g) for states in the fit's mode `number`."""
    modes = jnp.full_like(states[:, :1], number)
    inputs = jnp.concatenate([states / settings.half_width, modes], axis=-1)
    return cast(jax.Array, _network(settings).apply(params, inputs))[:, 0]


def fit(
    modes: Sequence[Mode],
    regularizer: Regularizer,
    *,
    seeds: Sequence[int],
    settings: Settings,
    report: Callable[[int], None],
) -> Any:
    """Fit one network per seed to all modes; returns their parameters, stacked.

    A seed determines initial weights and states, the same for every regulariser. `report` is called
    with the number of further updates done.
    """
    optimizer = optax.adam(optax.cosine_decay_schedule(settings.learning_rate, settings.steps))
    keys = jnp.stack([seed_key(seed) for seed in seeds])

    def init(key: Key[Array, ""]) -> tuple[Any, optax.OptState]:
        params = _network(settings).init(jax.random.fold_in(key, 0), jnp.zeros((1, 3)))
        return params, optimizer.init(params)

    def update(
        state: tuple[Any, optax.OptState], key: Key[Array, ""]
    ) -> tuple[Any, optax.OptState]:
        params, opt_state = state
        gradients = jax.grad(_loss)(params, key, modes, regularizer, settings)
        updates, opt_state = optimizer.update(gradients, opt_state)
        return optax.apply_updates(params, updates), opt_state

    @jax.jit
    def stretch(state: Any, start: Int[Array, ""], stop: Int[Array, ""]) -> Any:
        def step(number: Int[Array, ""], state: Any) -> Any:
            # Number 0 was used for the weights.
            return jax.vmap(update)(
                state, jax.vmap(jax.random.fold_in, (0, None))(keys, number + 1)
            )

        return jax.lax.fori_loop(start, stop, step, state)

    state = jax.jit(jax.vmap(init))(keys)
    for start in range(0, settings.steps, _STRETCH):
        stop = min(start + _STRETCH, settings.steps)
        state = jax.block_until_ready(stretch(state, start, stop))
        report(stop - start)
    return state[0]


def _network(settings: Settings) -> MLP:
    return MLP(settings.hidden_sizes, 1)


def _loss(
    params: Any,
    key: Key[Array, ""],
    modes: Sequence[Mode],
    regularizer: Regularizer,
    settings: Settings,
) -> Float[Array, ""]:
    """Mean over modes of the squared error and the weighted residual of V = -d."""
    shape = len(modes), settings.batch_size, 2
    samples = settings.half_width * jax.random.uniform(key, shape, minval=-1, maxval=1)

    def mode_loss(number: int, mode: Mode, states: States) -> Float[Array, ""]:
        values, residuals = regularizer.residuals(
            lambda states: -predict(settings, params, number, states),
            Transitions(states, mode.successor(states), _PLANE),
        )
        errors = values + mode.cost_to_go(states)
        return jnp.mean(errors**2 + regularizer.weight * residuals)

    losses = [mode_loss(*item) for item in zip(range(len(modes)), modes, samples, strict=True)]
    return jnp.mean(jnp.stack(losses))
