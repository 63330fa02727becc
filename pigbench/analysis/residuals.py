"""Residuals and gradients of a value function over the transitions of a data set."""

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Key, Shaped

from pigbench import seeds
from pigbench.agents import Agent, Params
from pigbench.agents.norms import safe_norm
from pigbench.agents.residuals import HJB, Eikonal, Transitions
from pigbench.analysis.modes import MODES, contact_modes
from pigbench.data import sampler
from pigbench.data.sampler import Rows

Equation = TypeVar("Equation", Eikonal, HJB)

_BATCH = 1000


class Residuals(NamedTuple):
    """Measurements of transitions.

    `eikonal` and `hjb` are the residuals of `agents/residuals.py`, with the goals and coordinates
    with which the agent trains its value (a hierarchy its low level's), and with its own constants
    of the equation if it trains on it, or else the usual ones. `gradient` is the norm of the
    gradient with respect to the state; `robot` and `object` are the shares of its square along
    their coordinates (NaN where the gradient is zero).
    """

    eikonal: Float[np.ndarray, "batch"]
    hjb: Float[np.ndarray, "batch"]
    gradient: Float[np.ndarray, "batch"]
    robot: Float[np.ndarray, "batch"]
    object: Float[np.ndarray, "batch"]


def measure(
    agent: Agent, params: Params, rows: Rows, *, samples: int, seed: int
) -> tuple[Shaped[np.ndarray, "batch"], Residuals]:
    """Contact modes and residuals of `samples` transitions, for the agent's value goals.

    Raises UserError if the agent learns no state value.
    """
    batches = -(-samples // _BATCH)
    measured = [
        _measure_batch(agent, params, rows, jax.random.fold_in(seeds.key(seed), number))
        for number in range(batches)
    ]
    states, *columns = (np.concatenate(parts)[:samples] for parts in zip(*measured, strict=True))
    return contact_modes(states, agent.layout), Residuals(*columns)


@partial(jax.jit, static_argnums=0)
def _measure_batch(
    agent: Agent, params: Params, rows: Rows, key: Key[Array, ""]
) -> tuple[Float[Array, "batch ..."], ...]:
    """The states and the columns of `Residuals`."""
    batch = sampler.sample(key, rows, agent.sampling, _BATCH)

    learner, learned, seen = agent.value_learner(params, batch)

    def value(states: Float[Array, "batch x"]) -> Float[Array, "batch"]:
        return jax.vmap(learner.state_value, (None, 0, 0))(learned, states, seen.value_goals)

    def residuals(kind: type[Equation]) -> Float[Array, "batch"]:
        return equation(kind, learner).residuals(value, transitions)[1]

    states = seen.observations
    transitions = Transitions(states, seen.next_observations, learner.coordinates)
    gradients = jax.grad(lambda states: value(states).sum())(states)
    squares = gradients**2 / jnp.sum(gradients**2, axis=-1, keepdims=True)

    def share(group: str) -> Float[Array, "batch"]:
        parts = learner.layout.group(group).values()
        return sum((squares[:, part].sum(axis=-1) for part in parts), start=jnp.zeros(len(states)))

    columns = residuals(Eikonal), residuals(HJB), safe_norm(gradients)
    return batch.observations, *columns, share("robot"), share("objects")


def equation(kind: type[Equation], agent: Agent) -> Equation:
    """The equation of this kind with the agent's constants, or the usual ones if it has none."""
    return agent.penalty if isinstance(agent.penalty, kind) else kind()


def by_mode(
    modes: Shaped[np.ndarray, "batch"], values: Float[np.ndarray, "batch"]
) -> Mapping[str, Float[np.ndarray, "_"]]:
    """The finite `values` of each mode that occurs."""
    finite = np.isfinite(values)
    return {mode: values[finite & (modes == mode)] for mode in MODES if (modes == mode).any()}
