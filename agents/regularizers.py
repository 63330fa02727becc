"""Physics-informed regularisers: residuals of differential equations that a value should obey.

A regulariser sees a value function of the state alone, V: (B, n) -> (B,), its goals already bound,
and returns the values with the residuals, so that the loss beside it needs no second forward pass.
Nothing here knows the network or the space: V may be the negative of a distance, and the state a
low-level representation.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from pigbench.agents.config import require
from pigbench.agents.directions import DIRECTIONS, Direction, Motion
from pigbench.agents.norms import safe_norm
from pigbench.errors import lookup

ValueFunction = Callable[[jax.Array], jax.Array]
ValuesAndResiduals = tuple[jax.Array, jax.Array]
OWN = Direction()


def gradient_norm(value: ValueFunction, states: jax.Array) -> tuple[jax.Array, jax.Array]:
    """V(s) and ||grad_s V(s)||, each (B,)."""
    values, pullback = jax.vjp(value, states)
    (gradients,) = pullback(jnp.ones_like(values))
    return values, safe_norm(gradients)


def unregularized(value: ValueFunction, states: jax.Array) -> ValuesAndResiduals:
    """V(s) with residuals of 0."""
    values = value(states)
    return values, jnp.zeros_like(values)


def eikonal_residual(
    value: ValueFunction, states: jax.Array, *, speed: jax.Array | float
) -> ValuesAndResiduals:
    """(||grad_s V|| S(s) - 1)^2, Eq. Eik_reg; `speed` is S(s), one number or (B,)."""
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
    """(grad_s d . u + 1)^2 with d = -V, Eq. ca_hjb.

    u is the `direction` of motion, by default (s' - s) / (||s' - s|| + epsilon).
    The slope along u is a forward-mode derivative: one pass gives it together with the value.
    """
    directions = direction(states, next_states, epsilon=epsilon)
    values, slopes = jax.jvp(value, (states,), (directions,))
    return values, (1 - slopes) ** 2


@dataclass(frozen=True)
class Regularizer:
    """Which regulariser a value loss carries, and its constants.

    Raises `UserError` if `kind` is none of `RESIDUALS` or a constant is out of range.
    """

    kind: str = "none"  # none, eikonal or hjb
    weight: float = 1.0  # lambda: the residual's factor in the loss
    speed: float = 1.0  # S(s) of the Eikonal equation, the same in all states
    epsilon: float = 1e-6  # of the HJB direction: keeps it finite where nothing moves
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
        """V(s) and the residual at s, each (B,); the residual is not yet weighted.

        `direction` is what the agent's own coordinates make of the one named here.
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
"""Residuals by name. A new one is a function above and a row here."""
