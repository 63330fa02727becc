"""One gradient step of any agent: the only module that handles optimisers and target networks."""

from functools import partial
from typing import Any, cast

import jax
import jax.numpy as jnp
import optax
from flax import struct
from jaxtyping import Int, PRNGKeyArray

from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import Batch
from pigbench.agents.metrics import Metrics
from pigbench.shapes import Array


@struct.dataclass
class TrainState:
    """The state that a training step updates."""

    params: Params
    target_params: Params  # of the agent's `target_networks` only
    opt_state: optax.OptState
    step: Int[Array, ""]  # number of updates done
    average: Params  # of `params` over recent updates; empty if the agent does not average

    @property
    def acting(self) -> Params:
        """The parameters to act with and to analyse."""
        return self.average or self.params


@partial(jax.jit, static_argnames="agent")  # else as many programs as operations
def create(agent: Agent[Any], key: PRNGKeyArray) -> TrainState:
    """Initial parameters, equal target parameters, and a fresh optimiser state."""
    params = agent.init(key)
    # Copied, because a state whose leaves share buffers cannot be donated.
    target_params, average = jax.tree.map(
        jnp.copy, (_targeted(agent, params), _averaged(agent, params))
    )
    return TrainState(
        params=params,
        target_params=target_params,
        opt_state=_optimizer(agent).init(params),
        step=jnp.zeros((), jnp.int32),
        average=average,
    )


def update(
    agent: Agent[Any], state: TrainState, batch: Batch, key: PRNGKeyArray
) -> tuple[TrainState, Metrics]:
    """One Adam step on the agent's loss, then target <- (1 - tau) target + tau params.

    The average is updated in the same way, first over the last tenth of all updates so far, and
    later at the agent's `average_rate`.

    Pure: the same arguments give the same state. `key` is for this step only.
    """
    gradients, metrics = jax.grad(agent.loss, has_aux=True)(
        state.params, state.target_params, batch, key
    )
    updates, opt_state = _optimizer(agent).update(gradients, state.opt_state)
    params = cast(Params, optax.apply_updates(state.params, updates))
    target_params = optax.incremental_update(
        _targeted(agent, params), state.target_params, agent.target_rate
    )
    average_rate = jnp.maximum(agent.average_rate, 10 / (state.step + 10))
    average = optax.incremental_update(_averaged(agent, params), state.average, average_rate)
    return TrainState(
        params=params,
        target_params=cast(Params, target_params),
        opt_state=opt_state,
        step=state.step + 1,
        average=cast(Params, average),
    ), metrics


def _optimizer(agent: Agent[Any]) -> optax.GradientTransformation:
    return optax.adam(agent.config.learning_rate)


def _targeted(agent: Agent[Any], params: Params) -> Params:
    return {name: params[name] for name in agent.target_networks}


def _averaged(agent: Agent[Any], params: Params) -> Params:
    return params if agent.average_rate < 1 else {}
