"""Physics-informed regularisers: residuals of differential equations that a value should satisfy.

A regulariser takes a value function of the state only, V: (B, n) -> (B,), with goals already bound,
and returns the values with the residuals, so that the value loss needs no second forward pass.
Nothing here depends on the network or the space: V may be a negative distance, and the state a
low-level representation.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from pigbench.agents.directions import DIRECTIONS, Direction, Motion
from pigbench.agents.norms import safe_norm
from pigbench.errors import lookup, require

ValueFunction = Callable[[jax.Array], jax.Array]
ValuesAndResiduals = tuple[jax.Array, jax.Array]
OWN = Direction()


def gradient_norm(value: ValueFunction, states: jax.Array) -> tuple[jax.Array, jax.Array]:
    """V(s) and ||grad_s V(s)||, each (B,)."""
    values, pullback = jax.vjp(value, states)
    (gradients,) = pullback(jnp.ones_like(values))
    return values, safe_norm(gradients)


def unregularized(value: ValueFunction, states: jax.Array) -> ValuesAndResiduals:
    """V(s) and residuals of 0."""
    values = value(states)
    return values, jnp.zeros_like(values)


def eikonal_residual(
    value: ValueFunction, states: jax.Array, *, speed: jax.Array | float
) -> ValuesAndResiduals:
    """(||grad_s V|| S(s) - 1)^2, the Eikonal residual; `speed` is S(s), a scalar or (B,).

    See "Physics-informed GCRL" in the paper.
    """
    values, norms = gradient_norm(value, states)
    return values, (norms * speed - 1) ** 2


def hjb_residual(
    value: ValueFunction,
    states: jax.Array,
    next_states: jax.Array,
    *,
    epsilon: float,
    direction: Motion = OWN,
) -> ValuesAndResiduals:
    """(grad_s d . u + 1)^2 with d = -V, the contact-aware HJB residual.

    u is the `direction` of motion, by default (s' - s) / (||s' - s|| + epsilon); see "Contact-aware
    physics-informed value learning" in the paper. The slope along u is a forward-mode derivative,
    which one pass computes together with the value.
    """
    directions = direction(states, next_states, epsilon=epsilon)
    values, slopes = jax.jvp(value, (states,), (directions,))
    return values, (1 - slopes) ** 2


@dataclass(frozen=True)
class Regularizer:
    """The regulariser of a value loss, and its constants.

    Raises `UserError` if `kind` is not in `RESIDUALS` or a constant is out of range.
    """

    kind: str = "none"  # none, eikonal or hjb
    weight: float = 1.0  # lambda: the weight of the residual, for a cost of 1, in the loss
    speed: float = 1.0  # S(s) of the Eikonal equation, the same in all states
    epsilon: float = 1e-6  # of the HJB direction, to keep it finite where nothing moves
    direction: str = "own"  # of HJB: own, raw, standardized or positions

    def __post_init__(self) -> None:
        lookup("regularizer", RESIDUALS, self.kind)
        lookup("direction", DIRECTIONS, self.direction)
        require(self, lambda x: x >= 0, "at least 0", "weight")
        require(self, lambda x: x > 0, "positive", "speed", "epsilon")

    def __call__(
        self,
        value: ValueFunction,
        states: jax.Array,
        next_states: jax.Array,
        direction: Direction = OWN,
    ) -> ValuesAndResiduals:
        """V(s) and the residual at s, each (B,); the residual is not weighted.

        `direction` is the field of that name as resolved in the agent's coordinates.
        """
        return RESIDUALS[self.kind](self, value, states, next_states, direction)


RESIDUALS: Mapping[
    str,
    Callable[[Regularizer, ValueFunction, jax.Array, jax.Array, Direction], ValuesAndResiduals],
] = {
    "none": lambda constants, value, states, *_: unregularized(value, states),
    "eikonal": lambda constants, value, states, *_: eikonal_residual(
        value, states, speed=constants.speed
    ),
    "hjb": lambda constants, value, states, next_states, direction: hjb_residual(
        value, states, next_states, epsilon=constants.epsilon, direction=direction
    ),
}
"""Residuals by name. To add one, write a function above and add a row here."""
